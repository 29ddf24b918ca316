//! What trimming, linearising and integrating need of an engine, with or without extra states.

use std::fmt::Debug;

use fd_core::Scalar;

use super::{
    auxiliary::Auxiliary,
    rhs::Engine17,
    state::{MEASURED, NX, NY},
};
use crate::error::{Compressor, EngineError};

/// An autonomous engine with `N` states and the fuel flow (kg/s) as its input.
///
/// The first seventeen states are those of [`Engine17`]; all outputs are states.
///
/// Another engine of the family implements these three methods, and is trimmed, linearised, integrated and
/// run as a plant like the original. Here one whose pump delivers two per cent less than it is told:
///
/// ```
/// use fd_core::stage::Plant;
/// use fd_jetengine::engine17::{
///     Auxiliary, Dynamics, Engine17, NX, NY, Parameters, Sampled, SurgeLimits,
/// };
/// use fd_model::SampleTime;
///
/// #[derive(Debug)]
/// struct WornPump(Engine17);
///
/// impl Dynamics<f64, NX> for WornPump {
///     fn rates(&self, x: &[f64; NX], fuel: f64) -> ([f64; NX], Auxiliary<f64>) {
///         self.0.rates(x, 0.98 * fuel)
///     }
///
///     fn surge_limits(&self) -> SurgeLimits<f64> {
///         self.0.surge_limits()
///     }
///
///     fn measured(&self) -> [usize; NY] {
///         self.0.measured()
///     }
/// }
///
/// // Started where the healthy engine is at rest, it slows down.
/// let healthy = Engine17::new(&Parameters::default())?;
/// let trim = healthy.trim(0.712)?;
/// let plant = Sampled::<_, NX>::new::<f64>(WornPump(healthy), SampleTime::new(0.02)?);
/// let (mut x, mut next) = (trim.x, [0.0; NX]);
/// for _ in 0..500 {
///     plant.advance(&x, &[0.712], &mut next);
///     x = next;
/// }
/// let (mut y, speed) = ([0.0; NY], trim.outputs()[0]);
/// plant.output(&x, &[0.712], &mut y);
/// assert!(0.9 * speed < y[0] && y[0] < 0.999 * speed);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Dynamics<T: Scalar, const N: usize>: Debug + Send + Sync {
    /// Rates of the states, per second, and the gas path at that instant.
    fn rates(&self, x: &[T; N], fuel: T) -> ([T; N], Auxiliary<T>);

    /// Limits of the surge indicators.
    fn surge_limits(&self) -> SurgeLimits<T>;

    /// Indices of the states that are the outputs `N_L, N_H, T_7, P_6, T_29`.
    fn measured(&self) -> [usize; NY];
}

/// Limits of the surge indicators.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurgeLimits<T = f64> {
    /// Least relative flow `x` of the low-pressure compressor.
    pub lpc_relative_flow: T,
    /// Largest loading `y` of the high-pressure compressor.
    pub hpc_loading: T,
}

impl<T: Scalar> Dynamics<T, NX> for Engine17<T> {
    fn rates(&self, x: &[T; NX], fuel: T) -> ([T; NX], Auxiliary<T>) {
        Engine17::rates(self, x, fuel)
    }

    fn surge_limits(&self) -> SurgeLimits<T> {
        let p = self.parameters();
        SurgeLimits {
            lpc_relative_flow: T::from_design(p.lpc.peak_flow),
            hpc_loading: T::from_design(p.hpc.surge_loading),
        }
    }

    fn measured(&self) -> [usize; NY] {
        MEASURED
    }
}

impl<T: Scalar> SurgeLimits<T> {
    /// Refuses a gas path in surge.
    ///
    /// # Errors
    ///
    /// Returns [`EngineError::Surge`] with the time in seconds that was given.
    pub fn check(&self, auxiliary: &Auxiliary<T>, time: f64) -> Result<(), EngineError> {
        let surge = |compressor, value: T, limit: T| {
            let (value, limit) = (value.to_report(), limit.to_report());
            Err(EngineError::Surge { compressor, value, limit, time })
        };
        let (x, y) = (auxiliary.lpc_relative_flow, auxiliary.hpc_loading);
        if y > self.hpc_loading {
            return surge(Compressor::HighPressure, y, self.hpc_loading);
        }
        if x < self.lpc_relative_flow {
            return surge(Compressor::LowPressure, x, self.lpc_relative_flow);
        }
        Ok(())
    }
}

/// Refuses a state that is not finite, or not positive among the first seventeen.
pub(super) fn check_state<T: Scalar>(x: &[T], time: f64) -> Result<(), EngineError> {
    for (index, &value) in x.iter().enumerate() {
        if !value.is_finite() || (index < NX && value <= T::zero()) {
            return Err(EngineError::NonFinite { index, value: value.to_report(), time });
        }
    }
    Ok(())
}
