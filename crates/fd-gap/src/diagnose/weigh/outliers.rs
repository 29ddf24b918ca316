//! Single wrong samples among good ones.
//!
//! Two descriptions compete. Either a share of the innovations is much wider than the rest, or, in noise
//! with a colour, a share of the samples is off by itself: whitened, such a sample would disturb those
//! after it, and the colour could not be told (additive and innovational outliers; Fox, *J. Roy. Stat.
//! Soc.* B 34, 1972).
//!
//! *When not to use:* for errors that come in bursts. They raise the likelihood as well, which is why
//! [`Outliers::bursts`] says what speaks for something else.

use std::f64::consts::PI;

use fd_numeric::{median, robust_deviation};

use super::gaussian::{count, gaussian};
use crate::{
    evidence::{DECADES, NoisePrior},
    quality::{MOST_OUTLIERS, NEIGHBOURS, OUTLIER_WIDTHS, neighbours, outlier_mixture},
};

/// Deviations from the neighbours, in their robust spread, from which a sample is off by itself.
const OFF: f64 = 5.0;
/// Innovations, in their spread, that count as wide.
const WIDE: f64 = 4.0;
/// Innovation of noise, as a fraction of it, below which what a wide one does lasts: no single sample is wrong then.
const SHORT: f64 = 0.5;
/// Wide ones so many samples after another are one burst.
const BURST: usize = 3;

/// What outliers make of the errors of an output.
#[derive(Clone, Debug)]
pub(super) struct Outliers {
    /// Logarithm of the evidence over that of noise.
    pub gain: f64,
    /// Share of the samples.
    pub share: f64,
    pub standard_error: f64,
    /// Log-likelihood ratio of bursts to independent samples.
    pub bursts: f64,
    /// Which samples are wrong, signal by signal.
    pub places: Vec<Vec<bool>>,
}

impl Outliers {
    /// Weighs outliers by errors in sigma; `None` without data.
    pub(super) fn of(signals: &[Vec<f64>], prior: NoisePrior) -> Option<Self> {
        let wide = Self::innovational(signals, prior);
        let alone = if prior.is_coloured { Self::additive(signals, prior) } else { None };
        [wide, alone].into_iter().flatten().max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// The errors without the wrong samples.
    pub(super) fn without(&self, signals: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let kept = |(e, is_wrong): (&f64, &bool)| if *is_wrong { f64::NAN } else { *e };
        let signals = signals.iter().zip(&self.places);
        signals.map(|(signal, places)| signal.iter().zip(places).map(kept).collect()).collect()
    }

    /// A share of the innovations is much wider than the rest.
    fn innovational(signals: &[Vec<f64>], prior: NoisePrior) -> Option<Self> {
        let found = gaussian(signals, prior);
        let colour = found.colour.first().filter(|colour| SHORT < colour.innovation())?;
        let (mut innovations, mut all, mut spreads) = (Vec::new(), Vec::new(), 0.0);
        for signal in signals {
            let mut white = vec![0.0; signal.len()];
            colour.whiten(signal, &mut white);
            let measured = white.iter().zip(signal).filter(|(_, e)| e.is_finite());
            innovations.extend(measured.map(|(w, _)| *w));
            spreads += colour.log_spread(signal);
            all.push(white);
        }
        let mixture = outlier_mixture(&innovations)?;
        let n = innovations.len() as f64;
        let log = mixture.log
            - prior.cost(mixture.scale.ln())
            - spreads
            - 0.5 * colour.order() as f64 * n.ln();
        let is_wide = |w: &f64| WIDE * mixture.scale < w.abs();
        let places = all.iter().map(|white| white.iter().map(is_wide).collect()).collect();
        Some(Self::new(log - found.log, mixture.share, n, places))
    }

    /// A share of the samples is off by itself. Without them the colour is that of the noise.
    fn additive(signals: &[Vec<f64>], prior: NoisePrior) -> Option<Self> {
        let deviations: Vec<Vec<f64>> = signals.iter().map(|s| from_neighbours(s)).collect();
        let mut sizes: Vec<f64> =
            deviations.iter().flatten().filter(|d| d.is_finite()).map(|d| d.abs()).collect();
        let spread = robust_deviation(&mut sizes)?;
        let is_off = |d: &f64| OFF * spread < d.abs();
        let places: Vec<Vec<bool>> =
            deviations.iter().map(|d| d.iter().map(is_off).collect()).collect();
        let (mut kept, mut wrong) = (signals.to_vec(), Vec::new());
        for (e, is_off) in kept.iter_mut().flatten().zip(places.iter().flatten()) {
            if *is_off {
                wrong.push(*e);
                *e = f64::NAN;
            }
        }
        let (n, m) = (count(signals), wrong.len() as f64);
        if wrong.is_empty() || MOST_OUTLIERS * n < m {
            return None;
        }
        let rest = gaussian(&kept, prior);
        let scale = *rest.scale.first()?;
        let wide = |width: f64| -> f64 {
            let s = width * scale;
            wrong.iter().map(|e| -0.5 * (e / s).powi(2) - s.ln() - 0.5 * (2.0 * PI).ln()).sum()
        };
        let wrong = OUTLIER_WIDTHS.map(wide).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let share = m / n;
        let which = m * share.ln() + (n - m) * (-share).ln_1p();
        let gain = rest.log + wrong + which - gaussian(signals, prior).log;
        Some(Self::new(gain, share, n, places))
    }

    /// With the price of the share, of which the data tell 1/√(n p), log-uniform before them; widths
    /// are on a coarse grid.
    fn new(gain: f64, share: f64, n: f64, places: Vec<Vec<bool>>) -> Self {
        let known = (share * n).max(1.0).sqrt();
        let occam =
            0.5 * (2.0 * PI).ln() - known.ln() - DECADES.ln() - (OUTLIER_WIDTHS.len() as f64).ln();
        let bursts = bursts(&places);
        Self { gain: gain + occam, share, standard_error: share / known, bursts, places }
    }
}

/// Samples minus the median of their neighbours; NaN where there are none.
fn from_neighbours(signal: &[f64]) -> Vec<f64> {
    let deviation = |k: usize| signal[k] - median(&mut neighbours(signal, k, NEIGHBOURS));
    (0..signal.len()).map(deviation).collect()
}

/// Log-likelihood ratio of bursts to independent events: how many follow another within a few samples
/// is Poisson distributed, with the mean that their share gives or with its own.
fn bursts(places: &[Vec<bool>]) -> f64 {
    let (mut events, mut samples, mut followers) = (0.0, 0.0_f64, 0.0);
    for places in places {
        for (k, is_event) in places.iter().enumerate() {
            samples += 1.0;
            if *is_event {
                events += 1.0;
                let past = &places[k.saturating_sub(BURST)..k];
                followers += f64::from(u8::from(past.contains(&true)));
            }
        }
    }
    let share: f64 = events / samples.max(1.0);
    let expected = events * (1.0 - (1.0 - share).powf(BURST as f64));
    if expected < followers {
        followers * (followers / expected).ln() - (followers - expected)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Independent events follow each other by accident only: the ratio is above 12 for one of
        /// e¹² = 160 000 logs (Chernoff's bound of a Poisson variable).
        #[test]
        fn accidents_are_no_bursts(share in 0.005..0.1, seed in 0_u64..1000) {
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
            let mut uniform = || {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1_u64 << 53) as f64
            };
            let places: Vec<bool> = (0..1000).map(|_| uniform() < share).collect();
            prop_assert!(bursts(&[places]) < 12.0);
        }

        /// Four of five follow another; independent ones would at most in 42 % of the cases (every
        /// sixth sample wrong): 22 at least.
        #[test]
        fn five_in_a_row_are_bursts(apart in 30_usize..100) {
            let places: Vec<bool> = (0..1000).map(|k| k % apart < 5).collect();
            prop_assert!(20.0 < bursts(&[places]));
        }
    }

    #[test]
    fn neighbours_tell_what_is_off() {
        let off = from_neighbours(&[0.0, 1.0, 9.0, 3.0, f64::NAN, 5.0]);
        assert_eq!(off[..4], [-1.0 - 4.0, 1.0 - 3.0, 9.0 - 1.0, 3.0 - 5.0]);
        assert!(off[4].is_nan());
    }
}
