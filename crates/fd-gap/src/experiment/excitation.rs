//! Inputs that an experiment could have.

use fd_model::{
    SampleTime,
    signal::{Chirp, MultiSine, Phases, Prbs, SignalError, Staircase, Sweep},
};

use super::result::{Excitation, Reach};
use crate::fit::Log;

/// Stages of the binary sequence.
const STAGES: u32 = 10;
/// Samples per clock of the binary sequence.
const CLOCK: f64 = 2.0;
/// Lines of a multisine.
const LINES: u32 = 8;
/// Part of an experiment before its input moves: what was before then does not matter.
const REST: usize = 20;
/// Samples that a level of the staircase is held.
const HOLD: [f64; 2] = [10.0, 80.0];

/// All kinds, the one that needs no change first.
pub(super) const ALL: [Excitation; 7] = [
    Excitation::Logged,
    Excitation::Larger,
    Excitation::Binary,
    Excitation::SlowSines,
    Excitation::FastSines,
    Excitation::Sweep,
    Excitation::Staircase,
];

impl Excitation {
    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Logged => "the logged input again",
            Self::Larger => "the logged input at twice the amplitude",
            Self::Binary => "a binary sequence",
            Self::SlowSines => "slow sinusoids",
            Self::FastSines => "fast sinusoids",
            Self::Sweep => "a sweep from slow to fast",
            Self::Staircase => "a staircase of random levels",
        }
    }
}

/// Inputs row by row, `samples` long, which begin where the logged ones do; `log` is the longest one, `ranges` those of all logs.
pub(super) fn inputs(
    excitation: Excitation,
    log: &Log,
    ranges: &[[f64; 2]],
    samples: usize,
    ts: SampleTime,
    reach: &Reach,
) -> Result<Vec<f64>, SignalError> {
    let columns: Result<Vec<Vec<f64>>, SignalError> = (0..log.nu)
        .map(|i| {
            let limits = reach.limits.as_ref().and_then(|limits| limits.get(i)).copied();
            let [low, high] = limits.unwrap_or(ranges[i]);
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            let logged = |k: usize| log.input(k)[i];
            if matches!(excitation, Excitation::Logged | Excitation::Larger) {
                let factor = if excitation == Excitation::Larger { 2.0 } else { 1.0 };
                let first = logged(0);
                let value = |k: usize| {
                    let value = first + factor * (logged(k % log.samples) - first);
                    limits.map_or(value, |[low, high]| value.clamp(low, high))
                };
                return Ok((0..samples).map(value).collect());
            }
            let shape = shape(excitation, samples, ts, reach.seed + i as u64)?;
            let peak = shape.iter().fold(f64::MIN_POSITIVE, |peak, v| peak.max(v.abs()));
            let rest = (samples / REST).max(1);
            let value = |k: usize| {
                let moved = k.checked_sub(rest).map(|k| middle + half * shape[k] / peak);
                moved.unwrap_or(logged(0))
            };
            Ok((0..samples).map(value).collect())
        })
        .collect();
    let columns = columns?;
    Ok((0..samples).flat_map(|k| columns.iter().map(move |column| column[k])).collect())
}

/// A signal about zero, of any size.
fn shape(
    excitation: Excitation,
    samples: usize,
    ts: SampleTime,
    seed: u64,
) -> Result<Vec<f64>, SignalError> {
    let nyquist = 0.5 / ts.seconds();
    let slowest = (2.0 / (samples as f64 * ts.seconds())).min(0.1 * nyquist);
    let sines = |low: f64, high: f64| {
        let step = (high / low).powf(1.0 / f64::from(LINES - 1));
        let frequencies = (0..LINES).map(|i| low * step.powi(i.cast_signed())).collect();
        let ones = vec![1.0; LINES as usize];
        MultiSine::new(frequencies, ones, Phases::Random { seed }).values(samples, ts)
    };
    match excitation {
        Excitation::Binary => {
            Prbs::new(STAGES, CLOCK * ts.seconds(), 1.0).seeded(97 * seed).values(samples, ts)
        }
        Excitation::SlowSines => sines(slowest, (0.03 * nyquist).max(1.5 * slowest)),
        Excitation::FastSines => sines(0.05 * nyquist, 0.5 * nyquist),
        Excitation::Sweep => {
            let duration = samples as f64 * ts.seconds();
            let mut chirp = Chirp::new(1.0, slowest, 0.3 * nyquist, duration);
            chirp.sweep = Sweep::Exponential;
            // Several inputs must not move together.
            chirp.phase_rad = seed as f64;
            chirp.values(samples, ts)
        }
        Excitation::Logged | Excitation::Larger | Excitation::Staircase => {
            let hold = HOLD.map(|samples| samples * ts.seconds());
            Staircase::new([-1.0, 1.0], hold, seed).values(samples, ts)
        }
    }
}
