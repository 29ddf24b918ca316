//! Runs of the nonlinear engine over seconds, with the fuel limited by the delivery pressure.

use serde::{Deserialize, Serialize};

use super::{
    discretise::{MAX_STEP, try_step},
    dynamics::Dynamics,
};
use crate::error::EngineError;

/// Limits of the fuel flow by the delivery pressure `P_3`, as fuel controls have them.
///
/// Without the upper one a slam surges the engine; without the lower one a chop puts the flame
/// out (which the model does not know).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FuelLimiter {
    /// Most fuel per delivery pressure, kg/s per kPa. Default 5.2e-4.
    pub accelerating: f64,
    /// Least fuel per delivery pressure, kg/s per kPa. Default 2.2e-4.
    pub decelerating: f64,
}

impl Default for FuelLimiter {
    fn default() -> Self {
        Self { accelerating: 5.2e-4, decelerating: 2.2e-4 }
    }
}

impl FuelLimiter {
    /// Fuel flow in kg/s that is allowed of a demand (kg/s) at a delivery pressure (kPa);
    /// NaN stays NaN.
    ///
    /// ```
    /// let limiter = fd_jetengine::engine17::FuelLimiter::default();
    /// assert!((limiter.limit(0.95, 1000.0) - 0.52).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn limit(&self, demand: f64, p_3: f64) -> f64 {
        let (least, most) = (self.decelerating * p_3, self.accelerating * p_3);
        // Comparisons let a NaN through, so that it is reported; `f64::max` would hide it.
        if demand > most {
            most
        } else if demand < least {
            least
        } else {
            demand
        }
    }
}

/// How a transient is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transient {
    /// Length of the run, s.
    pub duration: f64,
    /// Internal step, s; at most [`MAX_STEP`], the default.
    pub step: f64,
    /// Fuel limits, on by default.
    pub limiter: Option<FuelLimiter>,
}

impl Default for Transient {
    fn default() -> Self {
        Self { duration: 10.0, step: MAX_STEP, limiter: Some(FuelLimiter::default()) }
    }
}

/// The engine over time, one entry per internal step.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory<const N: usize> {
    /// Time between entries, s.
    pub step: f64,
    /// States, the initial ones first.
    pub states: Vec<[f64; N]>,
    /// Fuel flow after limiting, kg/s, held from each entry to the next.
    pub fuel: Vec<f64>,
}

impl Transient {
    /// Runs `engine` from `x` with the fuel demand (kg/s) as a function of time (s).
    ///
    /// # Errors
    ///
    /// [`EngineError::Surge`] with time and indicator when a compressor surges,
    /// [`EngineError::NonFinite`] when a state stops being a positive number, and
    /// [`EngineError::OutOfRange`] for a step or duration that cannot be run.
    pub fn run<const N: usize>(
        &self,
        engine: &impl Dynamics<f64, N>,
        x: [f64; N],
        demand: impl Fn(f64) -> f64,
    ) -> Result<Trajectory<N>, EngineError> {
        in_range("internal step", self.step, f64::MIN_POSITIVE, MAX_STEP)?;
        in_range("duration", self.duration, 0.0, 1e6)?;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked above")]
        let steps = (self.duration / self.step).round() as usize;
        let mut states = Vec::with_capacity(steps + 1);
        let mut fuel = Vec::with_capacity(steps);
        let mut x = x;
        states.push(x);
        for n in 0..steps {
            let time = n as f64 * self.step;
            let wanted = demand(time);
            let flow = self.limiter.map_or(wanted, |limiter| limiter.limit(wanted, x[P_3]));
            x = try_step(engine, &x, flow, self.step, time)?;
            states.push(x);
            fuel.push(flow);
        }
        Ok(Trajectory { step: self.step, states, fuel })
    }
}

/// Index of the delivery pressure among the states.
const P_3: usize = 4;

fn in_range(quantity: &'static str, value: f64, low: f64, high: f64) -> Result<(), EngineError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(EngineError::OutOfRange { quantity, value, low, high, unit: "s" })
}
