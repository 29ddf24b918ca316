//! From inputs and parameters to the bias of a residual.

use crate::{scalar::Scalar, stage::Stage};

/// A model of the bias `μ` that modelling errors leave in the residual, driven by `u`.
///
/// What a model lacks (a neglected state, a gain that is 5 % wrong) responds to the same inputs as the plant,
/// so the residual of a healthy plant is itself the output of a dynamic system with input `u`. A bias model is
/// that system: a few parameters `θ`, a few past values, and the arithmetic between them (Patton and Chen 1992,
/// eq. 13 to 16).
///
/// # The contract
///
/// The parameters come from outside, through [`load`](Self::load), in the order of the
/// [`Identifier`](super::Identifier) that learns them: those of residual channel 0 first. `load` changes
/// parameters and *never* the history; a model whose parameters are replaced between two samples continues from
/// where it was, which is why opening the switch of the compensator causes no jump.
///
/// Three methods advance the model by one sample. They differ in what the history holds afterwards:
///
/// | method | computes `μ̂` from | remembers | used |
/// |---|---|---|---|
/// | [`observe`](Self::observe) | nothing | the measured bias | to fill the history |
/// | [`predict`](Self::predict) | past *measured* residuals | the measured residual | innovations while training |
/// | [`simulate`](Self::simulate) | its *own* past | its own `μ̂` | compensation |
///
/// They are alternatives. For each sample at most one of them is called.
///
/// The whole method rests on the last row. `simulate` must not look at the residual in any way:
/// then no fault, however slow, can leak into `μ̂` and be subtracted as if it were bias. The signature
/// enforces it, and an implementor must not go around it by remembering `r` from an earlier call.
///
/// # Who calls it, and when
///
/// The compensator of `fd-compensate` holds two copies: a predictor that follows the training, and a
/// simulator that observes while the parameters are learned and simulates once they are frozen. So a
/// bias model is `Clone` in practice, and copies share nothing.
///
/// # What an implementor must do
///
/// * Start from a history of zeros, and accept `simulate` at once.
/// * Treat loaded parameters as memory: [`visit_state`](super::Stage::visit_state) shows them, and
///   [`reset`](super::Stage::reset) goes back to those that the model was built with.
/// * Write whatever an unstable `θ` leads to, up to infinity and NaN. The compensator watches for
///   divergence and rejects the model; a clamp would hide it.
/// * Neither allocate nor fail per sample. `load` is called per sample while training.
///
/// # How it composes
///
/// With any identifier of the same sizes, statically or as `Box<dyn BiasModel>`; the compensator
/// compares `nu`, `residual_len` and `theta_len` when it is built. In a spec the pair is chosen by
/// `bias.structure` and `bias.learning`. Models also wrap models: the Hammerstein model of
/// `fd-ident` puts functions of the inputs before any other one.
///
/// # When not to implement it
///
/// For a linear difference equation, take `fd_ident::arx`; for local equations over an operating
/// range, `fd_ident::scheduled`. For a bias whose cause is known, correct the model of the plant
/// instead: what is modelled need not be learned.
///
/// # Example
///
/// A first-order lag per channel, `μ(k) = p μ(k−1) + g u(k)`, with `θ = [p, g]`:
///
/// ```
/// use fd_core::{StateVisitor, stage::{BiasModel, Stage}};
///
/// #[derive(Clone, Debug, Default)]
/// struct Lag {
///     theta: [f64; 2],
///     past: f64,
/// }
///
/// impl Lag {
///     fn next(&self, u: &[f64]) -> f64 {
///         self.theta[0] * self.past + self.theta[1] * u[0]
///     }
/// }
///
/// impl Stage for Lag {
///     fn reset(&mut self) {
///         *self = Self::default();
///     }
///
///     fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
///         visitor.reals("lag parameters", &mut self.theta);
///         visitor.reals("lag past", std::slice::from_mut(&mut self.past));
///     }
/// }
///
/// impl BiasModel for Lag {
///     fn nu(&self) -> usize { 1 }
///     fn residual_len(&self) -> usize { 1 }
///     fn theta_len(&self) -> usize { 2 }
///
///     fn load(&mut self, theta: &[f64]) {
///         self.theta.copy_from_slice(theta);
///     }
///
///     fn observe(&mut self, _u: &[f64], mu: &[f64]) {
///         self.past = mu[0];
///     }
///
///     fn simulate(&mut self, u: &[f64], mu_hat: &mut [f64]) {
///         mu_hat[0] = self.next(u);
///         self.past = mu_hat[0];
///     }
///
///     fn predict(&mut self, u: &[f64], r: &[f64], mu_hat: &mut [f64]) {
///         mu_hat[0] = self.next(u);
///         self.past = r[0];
///     }
/// }
///
/// let mut simulator = Lag::default();
/// simulator.load(&[0.9, 0.1]);
/// let mut predictor = simulator.clone();
///
/// // The bias is 1; then a fault adds 0.5 to the residual, for good.
/// simulator.observe(&[1.0], &[1.0]);
/// predictor.observe(&[1.0], &[1.0]);
/// let (mut simulated, mut predicted) = ([0.0], [0.0]);
/// for _ in 0..20 {
///     let r = [1.0 + 0.5];
///     simulator.simulate(&[1.0], &mut simulated);
///     predictor.predict(&[1.0], &r, &mut predicted);
/// }
/// assert!((1.5 - simulated[0] - 0.5_f64).abs() < 1e-12, "the whole fault is left");
/// assert!((1.5 - predicted[0] - 0.05_f64).abs() < 1e-12, "a tenth of it, 1 − p");
/// ```
pub trait BiasModel<T: Scalar = f64>: Stage<T> {
    /// Number of inputs `u`.
    fn nu(&self) -> usize;

    /// Number of residual channels.
    fn residual_len(&self) -> usize;

    /// Number of parameters, all residual channels together.
    fn theta_len(&self) -> usize;

    /// Takes over parameters, those of residual channel 0 first.
    fn load(&mut self, theta: &[T]);

    /// Remembers a measured bias, so that a simulation can start from it without a transient.
    fn observe(&mut self, u: &[T], mu: &[T]);

    /// Simulates: computes `μ̂` from past and present inputs and its *own* past values. A fault
    /// in the residual cannot leak into it.
    fn simulate(&mut self, u: &[T], mu_hat: &mut [T]);

    /// Predicts one step: computes `μ̂` from past *measured* residuals, then remembers `r`. A
    /// fault leaks into the prediction after one sample, so this is for comparison only.
    fn predict(&mut self, u: &[T], r: &[T], mu_hat: &mut [T]);
}
