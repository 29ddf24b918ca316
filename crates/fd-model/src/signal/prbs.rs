//! Pseudo-random binary sequences of maximum length.

use serde::{Deserialize, Serialize};

use crate::{
    domain::SampleTime,
    signal::{
        check::{finite, positive_seconds},
        error::SignalError,
    },
};

/// A binary sequence `offset ± amplitude` from a feedback shift register.
///
/// With `bits` stages the sequence repeats after `2^bits − 1` clock periods, in which `+` occurs
/// exactly once more than `−`, and its cyclic autocorrelation is `−1/(2^bits − 1)` at every lag
/// but zero (Golomb 1967): as white as a periodic two-level signal can be, up to about 0.4 of
/// the clock frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prbs {
    /// Stages of the register, 2 to 24.
    pub bits: u32,
    /// Clock period in seconds, a whole multiple of the sample time.
    pub clock_s: f64,
    /// Half the distance between the levels, in the unit of the channel.
    pub amplitude: f64,
    /// Mean of the levels, in the unit of the channel.
    #[serde(default)]
    pub offset: f64,
    /// Where in its period the sequence starts: the register starts as
    /// `1 + seed mod (2^bits − 1)`.
    #[serde(default)]
    pub seed: u64,
}

/// Feedback taps of maximum-length registers with 2, 3, … stages, stages counted from 1.
///
/// The test `every_register_has_maximum_length` walks through the whole period of each.
const TAPS: [&[u32]; 23] = [
    &[2, 1],
    &[3, 2],
    &[4, 3],
    &[5, 3],
    &[6, 5],
    &[7, 6],
    &[8, 6, 5, 4],
    &[9, 5],
    &[10, 7],
    &[11, 9],
    &[12, 6, 4, 1],
    &[13, 4, 3, 1],
    &[14, 5, 3, 1],
    &[15, 14],
    &[16, 15, 13, 4],
    &[17, 14],
    &[18, 11],
    &[19, 6, 2, 1],
    &[20, 17],
    &[21, 19],
    &[22, 21],
    &[23, 18],
    &[24, 23, 22, 17],
];
const LEAST_BITS: u32 = 2;
pub(super) const MOST_BITS: u32 = 24;

impl Prbs {
    /// A sequence of `±amplitude`.
    ///
    /// ```
    /// # use fd_model::{SampleTime, signal::Prbs};
    /// let u = Prbs::new(3, 1.0, 1.0).values(7, SampleTime::new(1.0)?)?;
    /// assert_eq!(u.iter().sum::<f64>(), 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new(bits: u32, clock_s: f64, amplitude: f64) -> Self {
        Self { bits, clock_s, amplitude, offset: 0.0, seed: 0 }
    }

    /// Starts elsewhere in the period.
    #[must_use]
    pub fn seeded(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// The first `n` samples.
    ///
    /// # Errors
    ///
    /// Returns an error when the register length is not in the table, or the clock period is not
    /// a whole multiple of the sample time.
    pub fn values(&self, n: usize, ts: SampleTime) -> Result<Vec<f64>, SignalError> {
        finite("prbs", "amplitude", self.amplitude)?;
        finite("prbs", "offset", self.offset)?;
        let hold = self.samples_per_clock(ts)?;
        let register = Register::new(self.bits, self.seed)?;
        let levels = [self.offset - self.amplitude, self.offset + self.amplitude];
        Ok(register
            .flat_map(|bit| std::iter::repeat_n(levels[usize::from(bit)], hold))
            .take(n)
            .collect())
    }

    /// Clock periods until the sequence repeats, `2^bits − 1`.
    #[must_use]
    pub fn period(&self) -> u64 {
        1_u64.checked_shl(self.bits).map_or(u64::MAX, |p| p - 1)
    }

    fn samples_per_clock(&self, ts: SampleTime) -> Result<usize, SignalError> {
        positive_seconds("prbs", "clock_s", self.clock_s)?;
        let ratio = self.clock_s / ts.seconds();
        let whole = ratio.round();
        // A millionth allows for sample times such as 1/3 s that were typed as decimals.
        if whole < 1.0 || 1e-6 * whole < (ratio - whole).abs() {
            return Err(SignalError::Clock { clock_s: self.clock_s, ts_s: ts.seconds() });
        }
        // Saturates for clocks beyond any memory.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        Ok(whole as usize)
    }
}

/// A Fibonacci feedback shift register; iterates over its output for ever.
#[derive(Clone, Debug)]
pub(super) struct Register {
    pub state: u64,
    taps: u64,
    bits: u32,
}

impl Register {
    pub(super) fn new(bits: u32, seed: u64) -> Result<Self, SignalError> {
        let taps = bits
            .checked_sub(LEAST_BITS)
            .and_then(|i| TAPS.get(i as usize))
            .ok_or(SignalError::Register { least: LEAST_BITS, most: MOST_BITS, found: bits })?;
        let taps = taps.iter().fold(0, |mask, stage| mask | 1 << (stage - 1));
        let period = (1 << bits) - 1;
        Ok(Self { state: 1 + seed % period, taps, bits })
    }
}

impl Iterator for Register {
    type Item = bool;

    fn next(&mut self) -> Option<bool> {
        let out = self.state >> (self.bits - 1) & 1 == 1;
        let feedback = u64::from((self.state & self.taps).count_ones() & 1);
        self.state = (self.state << 1 | feedback) & ((1 << self.bits) - 1);
        Some(out)
    }
}
