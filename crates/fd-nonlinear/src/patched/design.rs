//! What a tracked simulation is made from.

use fd_core::{IoDims, StateVisitor};
use fd_model::{Record, Scaling};
use fd_sim::simulate::Simulator;

use super::{
    learn::{Learned, learn},
    run::Patched,
};
use crate::{error::NonlinearError, scaled::check_scaling};

/// Shift of a parameter for its slope, relative to its value.
const SHIFT: f64 = 1e-3;

/// A parameter that is tracked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracked {
    /// Its place among the parameters of the simulator.
    pub parameter: usize,
    /// Standard deviation of the step that it takes per sample, in its unit.
    pub drift: f64,
}

/// How parameters are tracked.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracking {
    /// Which.
    pub parameters: Vec<Tracked>,
    /// How far outside of what healthy logs showed the smoothed residual is before a fault is suspected:
    /// 1.5 is half as much again.
    pub suspicion: f64,
    /// Samples over which the residual is smoothed for that.
    pub memory: f64,
}

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

/// A tracked parameter at run time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub parameter: usize,
    pub variance: f64,
    pub shift: f64,
    pub bounds: [f64; 2],
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

    /// Lets parameters be tracked. How large the residual of a healthy plant is, how long it keeps its sign, and
    /// how far it goes when it is smoothed are learned from healthy logs in the signals of the pipeline; their
    /// first `settle` samples are left out.
    ///
    /// # Errors
    ///
    /// Returns an error when a setting is out of range, a parameter does not exist, a log has other channels, or
    /// there are too few complete samples to learn from.
    pub fn tracking(
        mut self,
        tracking: &Tracking,
        healthy: &[Record],
        settle: usize,
    ) -> Result<Self, NonlinearError> {
        let settings = [
            ("suspicion", tracking.suspicion, "a number of at least 1", 1.0),
            ("memory in samples", tracking.memory, "a number of at least 1", 1.0),
        ];
        for (setting, found, expected, least) in settings {
            if !(found.is_finite() && least <= found) {
                return Err(NonlinearError::Setting { setting, expected, found });
            }
        }
        let known = self.simulator.parameters();
        let axis = |tracked: &Tracked| {
            let Some(parameter) = known.get(tracked.parameter) else {
                let (setting, expected) = ("tracked parameter", "a place among the parameters");
                let found = tracked.parameter as f64;
                return Err(NonlinearError::Setting { setting, expected, found });
            };
            if !(tracked.drift.is_finite() && 0.0 < tracked.drift) {
                let (setting, expected) = ("drift of a tracked parameter", "finite and above 0");
                return Err(NonlinearError::Setting { setting, expected, found: tracked.drift });
            }
            let value = parameter.value;
            let size = if value.abs() > 0.0 { value.abs() } else { 1.0 };
            let [low, high] = parameter.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            Ok(Axis {
                parameter: tracked.parameter,
                variance: tracked.drift.powi(2),
                shift: SHIFT * size,
                bounds: [(low - value).min(0.0), (high - value).max(0.0)],
            })
        };
        let tracked = tracking.parameters.iter().map(axis).collect::<Result<_, _>>()?;
        self.smoothing = tracking.memory.recip();
        let learned = learn(&mut self.freeze(), healthy, settle, self.smoothing)?;
        Ok(Self { tracked, suspicion: tracking.suspicion, learned: Some(learned), ..self })
    }

    /// Channels of the plant.
    #[must_use]
    pub fn io(&self) -> IoDims {
        io(&*self.simulator)
    }

    /// Moves the residual to run time, at its start.
    #[must_use]
    pub fn freeze(&self) -> Patched {
        Patched::new(self)
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
