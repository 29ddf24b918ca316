//! A bound learned from healthy logs: a high quantile of the residual, given the input.

use faer::Mat;
use fd_numeric::{rms, wide::dot};

use super::{
    InputBound,
    bank::{Bands, InputNorms},
    non_negative::minimise,
};
use crate::{
    detect::error::{DetectorError, positive},
    rows::DrivenRows,
};

/// What is compared with the bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Evaluation {
    /// The magnitude of each sample.
    #[default]
    Magnitude,
    /// The root mean square over the window of the norms.
    RootMeanSquare,
}

/// How a bound is learned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearnedBound {
    /// Share of the healthy samples that the bound is to cover before it is calibrated; default 0.95.
    pub quantile: f64,
    /// What will be compared with the bound.
    pub evaluation: Evaluation,
}

impl Default for LearnedBound {
    fn default() -> Self {
        Self { quantile: 0.95, evaluation: Evaluation::default() }
    }
}

/// Samples that a quantile regression looks at; longer records are thinned evenly.
const MOST_SAMPLES: usize = 4000;

/// Rounds of the majorisation.
const ROUNDS: usize = 60;

/// Part of the size of the residual below which deviations count alike, and below which the noise is not
/// taken to be.
const LEAST_LEVEL: f64 = 1e-3;

impl InputBound {
    /// The non-negative `a`, `b` that bound the stated quantile of the residual, given the input, over
    /// healthy logs: linear quantile regression (Koenker & Bassett 1978), by majorisation of its loss
    /// (Hunter & Lange 2000).
    ///
    /// # Errors
    ///
    /// Returns an error when the record has no inputs, the quantile is not between 0 and 1, or a channel
    /// is zero throughout.
    ///
    /// # Examples
    ///
    /// ```
    /// use fd_compensate::{
    ///     DrivenRows, SampleRows,
    ///     detect::adaptive::{Bands, InputBound, LearnedBound},
    /// };
    ///
    /// // A residual of a tenth of a slow input.
    /// let u: Vec<f64> = (0..2000).map(|k| (f64::from(k) * 0.003).sin()).collect();
    /// let r: Vec<f64> = u.iter().map(|u| 0.1 * u).collect();
    /// let rows = DrivenRows::new(SampleRows::new(1, &u)?, SampleRows::new(1, &r)?)?;
    /// let bands = Bands::new(&[0.1], 20.0)?;
    /// let bound = InputBound::from_fault_free(rows, bands, &LearnedBound::default())?;
    /// assert!((bound.gain(0, 0, 0.0) - 0.1).abs() < 0.03);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_fault_free(
        healthy: DrivenRows<'_>,
        bands: Bands,
        learned: &LearnedBound,
    ) -> Result<Self, DetectorError> {
        let (nu, channels) = (healthy.nu(), healthy.residuals().channels());
        positive("inputs of the fault-free record", nu as f64)?;
        if !(learned.quantile > 0.0 && learned.quantile < 1.0) {
            let (parameter, expected) = ("quantile", "between 0 and 1");
            return Err(DetectorError::Parameter { parameter, expected, found: learned.quantile });
        }
        let (features, values) = look(healthy, &bands, learned.evaluation);
        let (mut noise, mut gains) = (Vec::new(), Vec::new());
        for (channel, values) in values.iter().enumerate() {
            let level = rms(values.iter().copied());
            if level <= 0.0 {
                let samples = healthy.len();
                return Err(DetectorError::ConstantChannel { channel, samples });
            }
            let weights = upper_envelope(&features, values, level, learned.quantile);
            noise.push(weights[0].max(LEAST_LEVEL * level));
            gains.extend_from_slice(&weights[1..]);
        }
        debug_assert_eq!(noise.len(), channels);
        Self::new(bands, nu, &noise, &gains)
    }
}

/// One and the norms of the inputs at each sample looked at, and what each channel shows there.
fn look(
    healthy: DrivenRows<'_>,
    bands: &Bands,
    evaluation: Evaluation,
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let mut norms = InputNorms::<f64>::new(bands, healthy.nu());
    let every = healthy.len().div_ceil(MOST_SAMPLES);
    let channels = healthy.residuals().channels();
    let mut power = vec![0.0; channels];
    let (mut features, mut values) = (Vec::new(), vec![Vec::new(); channels]);
    let mut beginnings = healthy.runs().map(|run| run.start).peekable();
    for k in 0..healthy.len() {
        if beginnings.next_if_eq(&k).is_some() {
            norms.reset();
            power.fill(0.0);
        }
        let forget = norms.forget();
        let now = norms.update(healthy.u(k));
        let is_looked_at = k % every == 0;
        if is_looked_at {
            features.push([1.0].into_iter().chain(now.iter().copied()).collect());
        }
        for ((values, power), r) in values.iter_mut().zip(&mut power).zip(healthy.r(k)) {
            *power += forget * (r * r - *power);
            if is_looked_at {
                values.push(match evaluation {
                    Evaluation::Magnitude => r.abs(),
                    Evaluation::RootMeanSquare => power.sqrt(),
                });
            }
        }
    }
    (features, values)
}

/// Non-negative weights of the features with the least pinball loss at `quantile`.
fn upper_envelope(features: &[Vec<f64>], values: &[f64], level: f64, quantile: f64) -> Vec<f64> {
    let count = features[0].len();
    // Features in units of their own size, so that the rounds converge alike in all of them.
    let scale: Vec<f64> = (0..count)
        .map(|l| features.iter().map(|f| f[l].abs()).fold(0.0, f64::max))
        .map(|peak| if peak > 0.0 { peak } else { 1.0 })
        .collect();
    // Feature by feature: this is gone over many times, and sums over long columns are quick.
    let columns: Vec<Vec<f64>> = scale
        .iter()
        .enumerate()
        .map(|(l, s)| features.iter().map(|f| f[l] / s).collect())
        .collect();
    let mut weights = vec![level / count as f64; count];
    let zeros = vec![0.0; values.len()];
    let (mut curvature, mut curved, mut pull) = (zeros.clone(), zeros.clone(), zeros);
    for _ in 0..ROUNDS {
        // What is fitted, in place of which goes the curvature of the quadratic that touches the loss at the
        // deviation from it.
        curvature.fill(0.0);
        for (column, weight) in columns.iter().zip(&weights) {
            curvature.iter_mut().zip(column).for_each(|(fitted, f)| *fitted += weight * f);
        }
        for (curvature, value) in curvature.iter_mut().zip(values) {
            *curvature = ((value - *curvature).abs() + LEAST_LEVEL * level).recip();
        }
        for ((pull, curvature), value) in pull.iter_mut().zip(&curvature).zip(values) {
            *pull = curvature * value + 2.0 * quantile - 1.0;
        }
        let right: Vec<f64> = columns.iter().map(|column| dot(column, &pull)).collect();
        let mut normal = Mat::<f64>::zeros(count, count);
        for (l, column) in columns.iter().enumerate() {
            for ((curved, curvature), f) in curved.iter_mut().zip(&curvature).zip(column) {
                *curved = curvature * f;
            }
            for (m, other) in columns[..=l].iter().enumerate() {
                normal[(l, m)] = dot(&curved, other);
                normal[(m, l)] = normal[(l, m)];
            }
        }
        weights = minimise(&normal, &right, weights);
    }
    weights.iter().zip(&scale).map(|(w, s)| w / s).collect()
}
