//! The subject of a diagnosis: a simulator, and a model into which effects can be spliced.

use fd_model::SampleTime;

use super::{EquationSimulator, SimulateError, Simulator};
use crate::{model::Model, scales::ReplayScales};

/// A simulator as its user brings it, with a model that effects can be spliced into.
///
/// For equations the two are the same. A black box lends its inputs, outputs, exposed parameters
/// and force ports to a shell of equations around it; effects are spliced into the shell.
///
/// ```
/// use fd_sim::{
///     equation::Expr,
///     model::Model,
///     patch::Patch,
///     simulate::{Nominal, SimulateError, Simulator},
/// };
///
/// /// The outputs after a hundred samples of a constant input, of any model that is diagnosed.
/// fn settled(nominal: &dyn Nominal, model: &Model) -> Result<f64, SimulateError> {
///     let mut simulator = nominal.patched(model, model.sample_time()?)?;
///     let (theta, x0): (Vec<f64>, Vec<f64>) = (
///         simulator.parameters().iter().map(|p| p.value).collect(),
///         simulator.initial().iter().map(|x| x.value).collect(),
///     );
///     let mut y = [0.0; 100];
///     simulator.simulate(&theta, &x0, &[1.0; 100], &mut y);
///     Ok(y[99])
/// }
///
/// let lag: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = { u = { unit = "1" } }
/// states = { x = { unit = "1", initial = 0.0, derivative = "5*(u - x)" } }
/// outputs = { y = { unit = "1", value = "x" } }
/// "#.parse()?;
///
/// // The same plant behind an actuator that delivers 80 % of what it is told.
/// let mut weak = Patch::of(&lag);
/// weak.wrap_input("u", "u_applied", Expr::parse("0.8*u")?)?;
/// let weak = weak.finish()?;
/// assert!((settled(&lag, &lag)? - 1.0).abs() < 1e-9);
/// assert!((settled(&lag, &weak)? - 0.8).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Nominal: std::fmt::Debug + Send + Sync {
    /// The model that effects are spliced into; its outputs carry the stated noise.
    fn model(&self) -> &Model;

    /// A simulator of the model with effects spliced in. Its parameters are those of the patched
    /// model, in that order.
    ///
    /// # Errors
    ///
    /// Returns an error when the patched model cannot be simulated with samples `ts` apart.
    fn patched(&self, model: &Model, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError>;

    /// A simulator without any effect.
    ///
    /// # Errors
    ///
    /// As [`patched`](Self::patched).
    fn simulator(&self, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError> {
        self.patched(self.model(), ts)
    }

    /// Whether it integrates with steps of its own, so that the step of a model changes nothing.
    fn keeps_step(&self) -> bool {
        false
    }

    /// Whether logged outputs are among its inputs, and no simulated one goes back to a controller.
    fn sees_the_log(&self) -> bool {
        false
    }

    /// Names of outputs that follow from what was logged, as the commands of a controller that sees the log do.
    fn commanded(&self) -> &[String] {
        &[]
    }

    /// Sizes of all signals of the model in a simulation without any effect.
    ///
    /// # Errors
    ///
    /// As [`ReplayScales::of`].
    fn scales(
        &self,
        ts: SampleTime,
        u: &[f64],
        samples: usize,
    ) -> Result<ReplayScales, SimulateError> {
        ReplayScales::of(self.model(), ts, u, samples)
    }
}

impl Nominal for Model {
    fn model(&self) -> &Model {
        self
    }

    fn patched(&self, model: &Model, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError> {
        Ok(Box::new(EquationSimulator::<f64>::at(model, ts)?))
    }
}
