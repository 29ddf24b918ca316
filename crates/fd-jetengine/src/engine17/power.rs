//! The four operating points at which the specification gives numbers.

use serde::{Deserialize, Serialize};

/// A named power setting at sea level, static, standard day.
///
/// ```
/// use fd_jetengine::engine17::{Engine17, Parameters, PowerSetting};
///
/// let engine = Engine17::new(&Parameters::default())?;
/// let idle = engine.trim(PowerSetting::Idle.fuel())?;
/// let high = engine.trim(PowerSetting::High.fuel())?;
/// assert!(9.0 * idle.auxiliary.thrust < high.auxiliary.thrust);
/// # Ok::<(), fd_jetengine::EngineError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PowerSetting {
    /// 0.12 kg/s of fuel; 5.4 kN of thrust.
    Idle,
    /// 0.40 kg/s of fuel; 23.3 kN of thrust.
    Mid,
    /// 0.712 kg/s of fuel, the reference point; 39.7 kN of thrust.
    Reference,
    /// 0.95 kg/s of fuel; 50.7 kN of thrust.
    High,
}

impl PowerSetting {
    /// All settings, from low to high.
    pub const ALL: [Self; 4] = [Self::Idle, Self::Mid, Self::Reference, Self::High];

    /// Fuel flow, kg/s.
    #[must_use]
    pub fn fuel(self) -> f64 {
        match self {
            Self::Idle => 0.12,
            Self::Mid => 0.40,
            Self::Reference => 0.712,
            Self::High => 0.95,
        }
    }
}
