//! Where the engine flies and how its geometry is set.

use fd_core::Scalar;
use serde::{Deserialize, Serialize};

use super::gas::{Gas, k};

/// Flight condition and settings of the variable geometry.
///
/// The default is sea level, static, standard day, with everything in its reference position.
///
/// ```
/// use fd_jetengine::engine17::Environment;
///
/// let climb = Environment { altitude: 3000.0, mach: 0.4, ..Environment::default() };
/// assert!((climb.ambient().temperature - 268.65_f64).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Environment {
    /// Geopotential altitude in m, 0 to 20 000. Default 0.
    pub altitude: f64,
    /// Flight Mach number, 0 to about 0.9. Default 0.
    pub mach: f64,
    /// Departure of the ambient temperature from the standard day in K. Default 0.
    pub isa_deviation: f64,
    /// Factor on the nozzle throat area. Default 1.
    pub nozzle_area: f64,
    /// Inlet guide vanes of the low-pressure compressor in degrees from the reference, closing
    /// positive. Default 0.
    pub guide_vanes: f64,
    /// Handling bleed as a fraction of the high-pressure compressor flow. Default 0.
    pub handling_bleed: f64,
}

impl Default for Environment {
    fn default() -> Self {
        Self {
            altitude: 0.0,
            mach: 0.0,
            isa_deviation: 0.0,
            nozzle_area: 1.0,
            guide_vanes: 0.0,
            handling_bleed: 0.0,
        }
    }
}

/// The air around the engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    /// Static temperature, K.
    pub temperature: f64,
    /// Static pressure, kPa.
    pub pressure: f64,
    /// Total temperature, K.
    pub total_temperature: f64,
    /// Total pressure before intake losses, kPa.
    pub total_pressure: f64,
}

impl Environment {
    /// International standard atmosphere with ram compression at γ = 1.4.
    #[must_use]
    pub fn ambient(&self) -> Ambient {
        let (standard, pressure) = if self.altitude < 11_000.0 {
            let t = 288.15 - 0.0065 * self.altitude;
            (t, 101.325 * (t / 288.15).powf(5.255_88))
        } else {
            (216.65, 22.632 * (-(self.altitude - 11_000.0) / 6341.62).exp())
        };
        let temperature = standard + self.isa_deviation;
        let ram = 1.0 + 0.2 * self.mach * self.mach;
        Ambient {
            temperature,
            pressure,
            total_temperature: temperature * ram,
            total_pressure: pressure * ram.powf(3.5),
        }
    }
}

/// What the engine swallows: constants of one flight condition in the scalar at hand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inlet<T> {
    /// Total temperature at the compressor face, K.
    pub t_1: T,
    /// Total pressure at the compressor face, kPa.
    pub p_1: T,
    /// Enthalpy at the compressor face, J/kg.
    pub h_1: T,
    /// Ambient static pressure, kPa.
    pub p_ambient: T,
    /// Flight speed, m/s.
    pub speed: T,
    /// `√(T_1 / 288.15 K)`.
    pub root_theta: T,
    /// `P_1 / 101.325 kPa`.
    pub delta: T,
}

impl<T: Scalar> Inlet<T> {
    pub(super) fn new(environment: &Environment, ram_recovery: f64) -> Self {
        let ambient = environment.ambient();
        let t_1 = ambient.total_temperature;
        let p_1 = ambient.total_pressure * ram_recovery;
        let sound = (1.4 * super::gas::GAS_CONSTANT * ambient.temperature).sqrt();
        Self {
            t_1: k(t_1),
            p_1: k(p_1),
            h_1: k(Gas::<f64>::air().enthalpy(t_1)),
            p_ambient: k(ambient.pressure),
            speed: k(environment.mach * sound),
            root_theta: k((t_1 / 288.15).sqrt()),
            delta: k(p_1 / 101.325),
        }
    }
}
