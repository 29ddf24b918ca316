//! Which parameters are tracked, and how: what healthy logs say of it is learned.

use fd_model::Record;

use super::{design::PatchedDesign, learn::learn, track::Axis};
use crate::error::NonlinearError;

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

impl PatchedDesign {
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
}
