//! From inputs and bias samples to parameters.

use std::iter::Sum;

use crate::{scalar::Scalar, stage::Stage};

/// A recursive estimator of the parameters of a bias model, as seen from `u` to each residual
/// channel.
///
/// While the plant is healthy the residual *is* the bias, `μ(k) = r(k)`, so the parameters of the bias model
/// can be learned from `(u, r)` sample by sample (Patton and Chen 1992, eq. 18). An identifier does only this.
/// When enough has been learned, whether the result is any good, and what to do with it, is decided by the
/// [`Compensator`](super::Compensator).
///
/// # The contract
///
/// * [`update`](Self::update) takes the input and the measured bias of one sample. Samples come in order of
///   time without gaps; if the caller has to leave some out, it calls `reset` or [`retrain`](Self::retrain)
///   first. The identifier therefore keeps the past samples of its regressor itself, and waits until they are
///   complete.
/// * [`theta`](Self::theta) is valid at any time, even before the first sample (usually zeros), and always has
///   the same length. Its order is that of the [`BiasModel`](super::BiasModel) it is made for: residual channel
///   0 first.
/// * [`variance_into`](Self::variance_into) writes one variance per parameter *for a noise of variance 1*. The
///   caller knows the variance of the innovations and multiplies. An estimator that cannot give a variance
///   writes infinity; a convergence test that asks for a standard error then never passes.
/// * [`guard`](Self::guard) counts what safeguards have done: samples not learned from, and times
///   the covariance was bounded. Counting matters: the convergence test does not count a skipped
///   sample as one at which `θ` stood still.
///
/// # Who calls it, and when
///
/// The compensator, in the training phase only: `theta` to predict, then `update` with the measured residual,
/// then `theta` again to see how far it moved. After the switch has opened, nothing is called until
/// [`retrain`](Self::retrain), which announces that the operating condition has changed. By default this
/// forgets everything. An identifier of local models may keep what it knows of other conditions, and then
/// returns `true`; past samples are forgotten in either case.
///
/// # What an implementor must do
///
/// * *Survive lack of excitation.* Inputs may stand still for hours. With forgetting and no excitation a
///   covariance grows without limit, and one sample later the estimate jumps (wind-up). Skip such samples,
///   bound the covariance, and report it through `guard`.
/// * *Stay finite.* Samples are finite, and the estimate must be too.
/// * *Not reject outliers.* An identifier that ignores outliers hides what the hard-fault test of the
///   compensator has to see.
/// * *Neither allocate nor fail* in `update`, `theta` and `variance_into`.
/// * *Show all memory* in [`visit_state`](super::Stage::visit_state): parameters, covariance, past samples,
///   counters. A training that is interrupted by a restart then continues bit for bit.
///
/// # How it composes
///
/// Statically with a kernel (`fd_ident::arx::RecursiveArx` makes the regressors, an `RlsKernel`
/// learns from them), as `Box<dyn Identifier>`, or by `bias.learning = { kind = … }` in a spec.
/// Whatever its type, the compensator pairs it with a bias model of the same sizes.
///
/// # When not to implement it
///
/// For another way of updating a covariance, implement `fd_ident::rls::RlsKernel`: regressors, histories and
/// channels are then taken care of. For parameters that are learned from whole logs, fit before the run and
/// start pre-fitted; nothing has to be recursive. For many units at once take `fd_ident::batch`, which updates
/// them in SIMD lanes.
///
/// # Example
///
/// Recursive least squares for one gain, `μ = θ u`. With one parameter the covariance is a number, and its
/// inverse is the energy of the input so far:
///
/// ```
/// use fd_core::{StateVisitor, stage::{GuardReport, Identifier, Stage}};
///
/// #[derive(Debug, Default)]
/// struct Gain {
///     theta: [f64; 1],
///     energy: f64,
///     skipped: u64,
/// }
///
/// impl Stage for Gain {
///     fn reset(&mut self) {
///         *self = Self::default();
///     }
///
///     fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
///         visitor.reals("gain", &mut self.theta);
///         visitor.reals("input energy", std::slice::from_mut(&mut self.energy));
///         visitor.counts("skipped", std::slice::from_mut(&mut self.skipped));
///     }
/// }
///
/// impl Identifier for Gain {
///     fn nu(&self) -> usize { 1 }
///     fn residual_len(&self) -> usize { 1 }
///
///     fn update(&mut self, u: &[f64], mu: &[f64]) {
///         if u[0] * u[0] <= f64::EPSILON * self.energy {
///             self.skipped += 1;
///             return;
///         }
///         self.energy += u[0] * u[0];
///         self.theta[0] += u[0] / self.energy * (mu[0] - self.theta[0] * u[0]);
///     }
///
///     fn theta(&self) -> &[f64] {
///         &self.theta
///     }
///
///     fn variance_into(&self, variance: &mut [f64]) {
///         variance[0] = self.energy.recip();
///     }
///
///     fn guard(&self) -> GuardReport {
///         GuardReport { skipped: self.skipped, bounded: 0 }
///     }
/// }
///
/// let mut gain = Gain::default();
/// let mut variance = [0.0];
/// gain.variance_into(&mut variance);
/// assert!(variance[0].is_infinite(), "nothing is known yet");
///
/// for u in [1.0, 0.0, -2.0, 0.0, 2.0] {
///     gain.update(&[u], &[0.3 * u]);
/// }
/// gain.variance_into(&mut variance);
/// assert!((gain.theta()[0] - 0.3).abs() < 1e-15);
/// assert_eq!(variance, [1.0 / 9.0]);
/// assert_eq!(gain.guard().skipped, 2, "two samples had no input to learn from");
///
/// assert!(!gain.retrain(&[0.3]), "it keeps nothing from other conditions");
/// assert_eq!(gain.theta(), [0.0]);
/// ```
pub trait Identifier<T: Scalar = f64>: Stage<T> {
    /// Number of inputs `u`.
    fn nu(&self) -> usize;

    /// Number of residual channels.
    fn residual_len(&self) -> usize;

    /// Learns from one sample of the bias `mu`, which equals the residual while the plant is
    /// healthy.
    fn update(&mut self, u: &[T], mu: &[T]);

    /// The current parameters, those of residual channel 0 first.
    fn theta(&self) -> &[T];

    /// Writes the variances of the parameters, in their order, relative to a noise of variance 1.
    fn variance_into(&self, variance: &mut [T]);

    /// What the safeguards against wind-up have done since the last reset.
    fn guard(&self) -> GuardReport;

    /// Starts learning under another operating condition; `theta` was in use so far. Returns whether what was
    /// learned under other conditions is kept; by default everything is forgotten, as by a reset.
    fn retrain(&mut self, theta: &[T]) -> bool {
        let _ = theta;
        self.reset();
        false
    }
}

/// What the safeguards of an [`Identifier`] have done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GuardReport {
    /// Samples not learned from, for want of excitation.
    pub skipped: u64,
    /// Times the covariance was bounded or reset.
    pub bounded: u64,
}

impl GuardReport {
    /// Whether any safeguard acted.
    #[must_use]
    pub fn acted(self) -> bool {
        self.skipped + self.bounded > 0
    }
}

/// The safeguards of several estimators together.
impl Sum for GuardReport {
    fn sum<I: Iterator<Item = Self>>(reports: I) -> Self {
        reports.fold(Self::default(), |sum, report| Self {
            skipped: sum.skipped + report.skipped,
            bounded: sum.bounded + report.bounded,
        })
    }
}
