//! The Kalman filter of parameters that walk at random.

use fd_core::{
    Buffer, Heap, Scalar, StateVisitor,
    stage::{GuardReport, Stage},
};
use fd_numeric::dot;
use serde::{Deserialize, Serialize};

use crate::{
    error::IdentError,
    rls::{Covariance, Guard, RlsKernel, RlsStorage, Ud, add_scaled, positive},
};

/// Covariance `Q` of what parameters move by from one sample to the next, relative to a noise of
/// variance 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Drift {
    /// `Q = variance · I`; 0 is ordinary least squares.
    Uniform {
        /// Variance of every parameter per sample.
        variance: f64,
    },
    /// `Q` is diagonal with one entry per parameter.
    PerParameter {
        /// Variances per sample, in the order of the parameters.
        variances: Vec<f64>,
    },
    /// `Q = (1/λ − 1) P`: exponential forgetting.
    Proportional {
        /// The forgetting factor.
        lambda: f64,
    },
}

impl Default for Drift {
    fn default() -> Self {
        Self::Uniform { variance: 0.0 }
    }
}

/// Settings of [`KalmanRls`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RandomWalkDesign {
    /// Variance of each parameter before the first sample, relative to a noise of variance 1.
    pub prior_variance: f64,
    /// How parameters move.
    pub drift: Drift,
    /// Safeguards; the drift pauses while the trace of `P` is above the limit.
    pub guard: Guard,
}

impl Default for RandomWalkDesign {
    fn default() -> Self {
        Self { prior_variance: 1e8, drift: Drift::default(), guard: Guard::default() }
    }
}

/// A Kalman filter for the parameters of one target, see the [module](super).
///
/// # Examples
///
/// A parameter that jumps is found again, because it is expected to move:
///
/// ```
/// use fd_ident::{random_walk::{Drift, KalmanRls, RandomWalkDesign}, rls::RlsKernel};
///
/// let drift = Drift::Uniform { variance: 0.1 };
/// let design = RandomWalkDesign { drift, ..RandomWalkDesign::default() };
/// let mut filter = KalmanRls::<f64>::new(1, &design)?;
/// let mut theta = [0.0];
/// for k in 0..80 {
///     filter.update(&[1.0], if k < 40 { 1.0 } else { 3.0 }, &mut theta);
/// }
/// assert!((theta[0] - 3.0).abs() < 1e-3);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Debug)]
pub struct KalmanRls<T: Scalar = f64, S: RlsStorage<T> = Heap> {
    covariance: Ud<T, S>,
    step: Step<T, S>,
    prior_variance: T,
    skip_silence: bool,
    largest_trace: T,
    report: GuardReport,
    p_phi: S::Parameters,
}

/// The time update.
#[derive(Clone, Debug)]
enum Step<T: Scalar, S: RlsStorage<T>> {
    /// Adds a diagonal.
    Add(S::Parameters),
    /// Multiplies by `1/λ`.
    Multiply(T),
}

impl<T: Scalar, S: RlsStorage<T>> KalmanRls<T, S> {
    /// A filter of `n` parameters.
    ///
    /// # Errors
    ///
    /// Returns an error when a variance is negative or not finite, a forgetting factor is out of
    /// range, or sizes do not fit.
    pub fn new(n: usize, design: &RandomWalkDesign) -> Result<Self, IdentError> {
        positive("prior variance", design.prior_variance)?;
        let limit = design.guard.trace_limit;
        if limit.is_nan() || limit < 1.0 {
            let (setting, expected) = ("trace limit", "at least 1");
            return Err(IdentError::Setting { setting, expected, found: limit });
        }
        let step = match &design.drift {
            Drift::Uniform { variance } => Step::Add(diagonal::<T, S>(n, &vec![*variance; n])?),
            Drift::PerParameter { variances } => Step::Add(diagonal::<T, S>(n, variances)?),
            Drift::Proportional { lambda } => {
                if !(0.0 < *lambda && *lambda <= 1.0) {
                    let (setting, expected) = ("forgetting factor", "above 0 and at most 1");
                    return Err(IdentError::Setting { setting, expected, found: *lambda });
                }
                Step::Multiply(T::from_design(*lambda).recip())
            }
        };
        let prior_variance = T::from_design(design.prior_variance);
        let covariance = Ud::isotropic(n, prior_variance)?;
        Ok(Self {
            largest_trace: covariance.trace() * T::from_design(limit),
            covariance,
            step,
            prior_variance,
            skip_silence: design.guard.skip_silence,
            report: GuardReport::default(),
            p_phi: S::Parameters::zeros("gain", n)?,
        })
    }

    /// The covariance `P`.
    #[must_use]
    pub fn covariance(&self) -> &Ud<T, S> {
        &self.covariance
    }
}

fn diagonal<T: Scalar, S: RlsStorage<T>>(
    n: usize,
    variances: &[f64],
) -> Result<S::Parameters, IdentError> {
    if variances.len() != n {
        let (setting, expected) = ("number of drift variances", "one per parameter");
        return Err(IdentError::Setting { setting, expected, found: variances.len() as f64 });
    }
    let mut q = S::Parameters::zeros("drift Q", n)?;
    for (q, &variance) in q.as_mut().iter_mut().zip(variances) {
        if !(variance >= 0.0 && variance.is_finite()) {
            let (setting, expected) = ("drift variance", "finite and not negative");
            return Err(IdentError::Setting { setting, expected, found: variance });
        }
        *q = T::from_design(variance);
    }
    Ok(q)
}

impl<T: Scalar, S: RlsStorage<T>> RlsKernel<T> for KalmanRls<T, S> {
    fn parameters(&self) -> usize {
        self.p_phi.as_ref().len()
    }

    fn update(&mut self, phi: &[T], target: T, theta: &mut [T]) {
        let innovation = target - dot(phi, theta);
        let energy = self.covariance.energy(phi);
        let silent = self.skip_silence && energy.abs() <= T::default_epsilon();
        if silent || !energy.is_finite() || !innovation.is_finite() {
            self.report.skipped += 1;
            return;
        }
        let trace = self.covariance.trace();
        match &self.step {
            Step::Add(q) => {
                let added = q.as_ref().iter().fold(T::zero(), |sum, &q| sum + q);
                if trace + added <= self.largest_trace {
                    self.covariance.add_diagonal(q.as_ref());
                } else {
                    self.report.bounded += 1;
                }
            }
            Step::Multiply(factor) => {
                if trace * *factor <= self.largest_trace {
                    self.covariance.scale(*factor);
                } else {
                    self.report.bounded += 1;
                }
            }
        }
        self.covariance.energy(phi);
        let one = T::one();
        let gain = self.covariance.learn(one, one, one, self.p_phi.as_mut());
        add_scaled(theta, gain * innovation, self.p_phi.as_ref());
    }

    fn variance_into(&self, variance: &mut [T]) {
        self.covariance.diagonal_into(variance);
    }

    fn guard(&self) -> GuardReport {
        self.report
    }
}

impl<T: Scalar, S: RlsStorage<T>> Stage<T> for KalmanRls<T, S> {
    fn reset(&mut self) {
        self.covariance.restart(self.prior_variance);
        self.report = GuardReport::default();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.covariance.visit(visitor);
        let mut counts = [self.report.skipped, self.report.bounded];
        visitor.counts("skipped, bounded", &mut counts);
        [self.report.skipped, self.report.bounded] = counts;
    }
}
