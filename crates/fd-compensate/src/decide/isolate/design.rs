//! Design of isolation: hypotheses, fault-free noise, and the required certainty.

use std::ops::Range;

use faer::Mat;
use fd_numeric::dense::Dense;
use serde::{Deserialize, Serialize};

use crate::{
    calibrate::autocorrelation_time,
    decide::{error::RuleError, size::Hypothesis},
    detect::chi_square::{moments, whitening},
    rows::SampleRows,
};

/// What a fault may do to the residual.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// A lasting fault of size 1 leaves this.
    Signature(Vec<f64>),
    /// Each of these channels may respond, in any way; the others do not: a column of a structure matrix.
    Responds(Vec<bool>),
}

impl Effect {
    /// The effect of one fault on a bank, whose block `b` of channels `blocks[b]` responds to it if
    /// `responds[b]`.
    ///
    /// ```
    /// use fd_compensate::decide::Effect;
    ///
    /// // Three residuals of a generalised bank, the middle one with two channels and deaf to this fault.
    /// let effect = Effect::on_blocks(&[0..1, 1..3, 3..4], &[true, false, true]);
    /// assert_eq!(effect, Effect::Responds(vec![true, false, false, true]));
    /// ```
    #[must_use]
    pub fn on_blocks(blocks: &[Range<usize>], responds: &[bool]) -> Self {
        let channels = blocks.iter().map(|block| block.end).max().unwrap_or(0);
        let mut responding = vec![false; channels];
        for (block, _) in blocks.iter().zip(responds).filter(|(_, responds)| **responds) {
            responding[block.clone()].fill(true);
        }
        Self::Responds(responding)
    }
}

/// One of the things that may have happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Candidate {
    /// Name, such as that of the sensor.
    pub name: String,
    /// What it does to the residual.
    pub effect: Effect,
    /// How likely it is next to the others before there is any evidence.
    pub weight: f64,
}

impl From<Hypothesis> for Candidate {
    fn from(Hypothesis { name, signature }: Hypothesis) -> Self {
        Self { name, effect: Effect::Signature(signature), weight: 1.0 }
    }
}

/// How sure one has to be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Isolation {
    /// Samples after the first alarm that are left out, for the transient of the residual to die away;
    /// default 0.
    pub settling: u64,
    /// Time constant in samples of the mean; `None` (default) averages all samples since the alarm.
    pub memory: Option<f64>,
    /// `ε`: how far a signature may be off, relative to its length; default 0.05.
    pub tolerance: f64,
    /// Prior weight of a fault that is none of the candidates, next to theirs; default 1.
    pub unknown: f64,
    /// Prior weight of a false alarm; default 1.
    pub false_alarm: f64,
    /// Least probability at which a candidate is named; default 0.5.
    pub naming: f64,
    /// Probability that the interval of a size covers; default 0.9.
    pub coverage: f64,
}

impl Default for Isolation {
    fn default() -> Self {
        Self {
            settling: 0,
            memory: None,
            tolerance: 0.05,
            unknown: 1.0,
            false_alarm: 1.0,
            naming: 0.5,
            coverage: 0.9,
        }
    }
}

impl Isolation {
    pub(super) fn check(&self) -> Result<(), RuleError> {
        let refuse =
            |parameter, expected, found| Err(RuleError::Number { parameter, expected, found });
        let weights = [
            ("tolerance", self.tolerance),
            ("weight of an unknown fault", self.unknown),
            ("weight of a false alarm", self.false_alarm),
        ];
        if let Some((parameter, found)) =
            weights.into_iter().find(|(_, v)| !(*v >= 0.0 && v.is_finite()))
        {
            return refuse(parameter, "non-negative and finite", found);
        }
        if !(0.0..=1.0).contains(&self.naming) {
            return refuse("naming", "between 0 and 1", self.naming);
        }
        if !(self.coverage > 0.0 && self.coverage < 1.0) {
            return refuse("coverage", "between 0 and 1", self.coverage);
        }
        Ok(())
    }
}

/// Independent samples that a record counts as which does not forget itself.
const DRIFT_WORTH: f64 = 10.0;

/// The residual without a fault: mean, whitening matrix and memory.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultFree {
    pub(super) mean: Vec<f64>,
    pub(super) whitening: Mat<f64>,
    pub(super) time: f64,
}

impl FaultFree {
    /// From given mean, covariance (row by row), and integrated autocorrelation time in samples.
    ///
    /// # Errors
    ///
    /// Returns an error when sizes differ, the covariance is not positive definite or the time is below one
    /// sample.
    pub fn new(mean: &[f64], covariance: &[f64], time: f64) -> Result<Self, RuleError> {
        let n = mean.len();
        crate::detect::error::length("covariance", n * n, covariance.len())?;
        if !(time >= 1.0 && time.is_finite()) {
            let (parameter, expected) = ("autocorrelation time", "finite and at least 1 sample");
            return Err(RuleError::Number { parameter, expected, found: time });
        }
        let whitening = whitening(&Mat::from_fn(n, n, |i, j| covariance[i * n + j]), 0)?;
        Ok(Self { mean: mean.to_vec(), whitening, time })
    }

    /// From fault-free residuals.
    ///
    /// A residual that does not forget itself within the record, as an uncompensated one that follows a slow
    /// input, counts as worth ten independent samples, so that nothing is concluded from its mean in haste.
    ///
    /// # Errors
    ///
    /// Returns an error when a channel is constant or a combination of the others.
    pub fn from_samples(healthy: SampleRows<'_>) -> Result<Self, RuleError> {
        let (mean, covariance) = moments(healthy);
        let whitening = whitening(&covariance, healthy.len())?;
        let drifting = (healthy.len() as f64 / DRIFT_WORTH).max(1.0);
        let time = (0..healthy.channels())
            .map(|channel| autocorrelation_time(&healthy.channel(channel).collect::<Vec<_>>()))
            .fold(1.0, |worst: f64, time| worst.max(time.unwrap_or(drifting)));
        Ok(Self { mean, whitening, time })
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.mean.len()
    }

    /// Orthonormal directions of `z` that an effect allows, one in each row, and the length of its
    /// whitened signature if it has one; `None` when it allows nothing or does not fit.
    pub(super) fn directions(&self, effect: &Effect) -> Option<(Mat<f64>, Option<f64>)> {
        let n = self.channels();
        match effect {
            Effect::Signature(gains) => {
                if gains.len() != n || gains.iter().any(|g| !g.is_finite()) {
                    return None;
                }
                let white = &self.whitening * Mat::from_fn(n, 1, |i, _| gains[i]);
                let length = white.norm_l2();
                let row = Mat::from_fn(1, n, |_, i| white[(i, 0)] / length);
                (length > 0.0).then_some((row, Some(length)))
            }
            Effect::Responds(responds) => {
                let chosen: Vec<usize> =
                    (0..n).filter(|&i| responds.get(i) == Some(&true)).collect();
                if responds.len() != n || chosen.is_empty() {
                    return None;
                }
                let columns = Mat::from_fn(n, chosen.len(), |i, j| self.whitening[(i, chosen[j])]);
                let basis = columns.factor_qr().compute_thin_Q();
                Some((basis.transpose().to_owned(), None))
            }
        }
    }
}
