//! What a tracked simulation is made from.

use fd_core::{IoDims, StateVisitor};
use fd_model::Scaling;
use fd_sim::simulate::Simulator;

use super::{learn::Learned, track::Axis};
use crate::{error::NonlinearError, scaled::check_scaling};

/// A simulation with tracked parameters.
#[derive(Clone, Debug)]
pub struct PatchedDesign {
    pub(super) simulator: Box<dyn Simulator>,
    pub(super) scaling: Scaling,
    pub(super) theta: Vec<f64>,
    pub(super) start: Vec<f64>,
    /// Place, drift, shift for the slope, and bounds as distances from the value.
    pub(super) tracked: Vec<Axis>,
    /// Weight of a sample in the smoothed residual, and the factor of its limits.
    pub(super) smoothing: f64,
    pub(super) suspicion: f64,
    pub(super) learned: Option<Learned>,
}

impl PatchedDesign {
    /// The residual of a simulator with its nominal parameters and initial states, none of them tracked. The
    /// signals of the pipeline are `(v − offset) / scale` of those of the simulator.
    ///
    /// # Errors
    ///
    /// Returns an error when there is not one scale per channel, or the simulator cannot show its memory, which
    /// a snapshot needs.
    ///
    /// # Examples
    ///
    /// A lag with a dead band, as a gap diagnosis would have found it:
    ///
    /// ```
    /// use fd_core::{Frame, stage::ResidualGenerator};
    /// use fd_model::{ChannelScale, Scaling};
    /// use fd_nonlinear::patched::PatchedDesign;
    /// use fd_sim::{model::Model, simulate::EquationSimulator};
    ///
    /// let model: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "valve"
    /// sample_time = 0.1
    /// parameters = { band = { unit = "1", value = 0.2 } }
    /// inputs = { u = { unit = "1" } }
    /// states = { x = { unit = "1", initial = 0.0, derivative = "u - clamp(u, -band, band) - x" } }
    /// outputs = { y = { unit = "1", value = "x" } }
    /// "#.parse()?;
    /// let plain = vec![ChannelScale::default()];
    /// let scaling = Scaling { inputs: plain.clone(), outputs: plain };
    /// let simulator = EquationSimulator::<f64>::new(&model)?;
    /// let mut residual = PatchedDesign::new(Box::new(simulator), scaling)?.freeze();
    /// let mut r = [0.0];
    /// for k in 0..100 {
    ///     residual.step(Frame::new(residual.io(), k, &[1.0], &[0.9])?, &mut r);
    /// }
    /// // The simulated valve has come to rest at 1.0 − 0.2.
    /// assert!((r[0] - 0.1).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(simulator: Box<dyn Simulator>, scaling: Scaling) -> Result<Self, NonlinearError> {
        check_scaling(io(&*simulator), &scaling)?;
        if !simulator.boxed().visit_memory(&mut Nobody) {
            return Err(NonlinearError::NoMemory);
        }
        Ok(Self {
            theta: simulator.parameters().iter().map(|parameter| parameter.value).collect(),
            start: simulator.initial().iter().map(|state| state.value).collect(),
            simulator,
            scaling,
            tracked: Vec::new(),
            smoothing: 1.0,
            suspicion: f64::INFINITY,
            learned: None,
        })
    }

    /// Channels of the plant.
    #[must_use]
    pub fn io(&self) -> IoDims {
        io(&*self.simulator)
    }
}

fn io(simulator: &dyn Simulator) -> IoDims {
    IoDims { nu: simulator.inputs().len(), ny: simulator.outputs().len() }
}

/// Looks at a memory and keeps nothing.
struct Nobody;

impl StateVisitor<f64> for Nobody {
    fn reals(&mut self, _name: &'static str, _values: &mut [f64]) {}

    fn counts(&mut self, _name: &'static str, _values: &mut [u64]) {}
}
