//! The thirteen health parameters of the engine.

use serde::{Deserialize, Serialize};

/// Condition of the modules: factors around 1 and one leak around 0.
///
/// High- and low-pressure turbine efficiency act almost alike on the five outputs, and fuel
/// heating value and combustor efficiency act exactly alike (only their product enters): no
/// diagnosis from these outputs can tell the latter two apart.
///
/// The scalar is generic, so that a dual number gives exact sensitivities to health.
///
/// ```
/// use fd_jetengine::engine17::Health;
///
/// let fouled = Health { hpc_efficiency: 0.98, hpc_flow: 0.98, ..Health::default() };
/// assert_ne!(fouled, Health::default());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    default,
    deny_unknown_fields,
    bound(deserialize = "T: num_traits::One + num_traits::Zero + Deserialize<'de>")
)]
pub struct Health<T = f64> {
    /// Factor on the low-pressure compressor efficiency. Default 1.
    pub lpc_efficiency: T,
    /// Factor on the low-pressure compressor flow capacity. Default 1.
    pub lpc_flow: T,
    /// Factor on the high-pressure compressor efficiency. Default 1.
    pub hpc_efficiency: T,
    /// Factor on the high-pressure compressor flow capacity. Default 1.
    pub hpc_flow: T,
    /// Factor on the high-pressure turbine efficiency. Default 1.
    pub hpt_efficiency: T,
    /// Factor on the high-pressure turbine flow capacity. Default 1.
    pub hpt_flow: T,
    /// Factor on the low-pressure turbine efficiency. Default 1.
    pub lpt_efficiency: T,
    /// Factor on the low-pressure turbine flow capacity. Default 1.
    pub lpt_flow: T,
    /// Factor on the nozzle throat area. Default 1.
    pub nozzle_area: T,
    /// Leak of compressor delivery air overboard, as a fraction of its flow. Default 0.
    pub bleed_leak: T,
    /// Factor on the turbine cooling flow. Default 1.
    pub cooling_flow: T,
    /// Factor on the combustor efficiency. Default 1.
    pub combustor_efficiency: T,
    /// Factor on the fuel heating value. Default 1.
    pub heating_value: T,
}

impl<T: num_traits::One + num_traits::Zero> Default for Health<T> {
    fn default() -> Self {
        Self {
            lpc_efficiency: T::one(),
            lpc_flow: T::one(),
            hpc_efficiency: T::one(),
            hpc_flow: T::one(),
            hpt_efficiency: T::one(),
            hpt_flow: T::one(),
            lpt_efficiency: T::one(),
            lpt_flow: T::one(),
            nozzle_area: T::one(),
            bleed_leak: T::zero(),
            cooling_flow: T::one(),
            combustor_efficiency: T::one(),
            heating_value: T::one(),
        }
    }
}

/// Name of one health parameter, for tables and fault scenarios.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "each variant is the field of `Health` of the same name")]
pub enum HealthParameter {
    LpcEfficiency,
    LpcFlow,
    HpcEfficiency,
    HpcFlow,
    HptEfficiency,
    HptFlow,
    LptEfficiency,
    LptFlow,
    NozzleArea,
    BleedLeak,
    CoolingFlow,
    CombustorEfficiency,
    HeatingValue,
}

impl HealthParameter {
    /// All health parameters.
    pub const ALL: [Self; 13] = [
        Self::LpcEfficiency,
        Self::LpcFlow,
        Self::HpcEfficiency,
        Self::HpcFlow,
        Self::HptEfficiency,
        Self::HptFlow,
        Self::LptEfficiency,
        Self::LptFlow,
        Self::NozzleArea,
        Self::BleedLeak,
        Self::CoolingFlow,
        Self::CombustorEfficiency,
        Self::HeatingValue,
    ];

    /// Efficiency and flow capacity of the four turbomachines: what differs from engine to engine
    /// and deteriorates.
    pub const MODULES: [Self; 8] = [
        Self::LpcEfficiency,
        Self::LpcFlow,
        Self::HpcEfficiency,
        Self::HpcFlow,
        Self::HptEfficiency,
        Self::HptFlow,
        Self::LptEfficiency,
        Self::LptFlow,
    ];
}

impl HealthParameter {
    /// Name of the field of [`Health`], as in configuration files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::LpcEfficiency => "lpc_efficiency",
            Self::LpcFlow => "lpc_flow",
            Self::HpcEfficiency => "hpc_efficiency",
            Self::HpcFlow => "hpc_flow",
            Self::HptEfficiency => "hpt_efficiency",
            Self::HptFlow => "hpt_flow",
            Self::LptEfficiency => "lpt_efficiency",
            Self::LptFlow => "lpt_flow",
            Self::NozzleArea => "nozzle_area",
            Self::BleedLeak => "bleed_leak",
            Self::CoolingFlow => "cooling_flow",
            Self::CombustorEfficiency => "combustor_efficiency",
            Self::HeatingValue => "heating_value",
        }
    }
}

impl<T: Copy> Health<T> {
    /// Value of one parameter.
    ///
    /// ```
    /// use fd_jetengine::engine17::{Health, HealthParameter};
    ///
    /// assert_eq!(Health::<f64>::default().get(HealthParameter::HptFlow), 1.0);
    /// ```
    #[must_use]
    pub fn get(mut self, parameter: HealthParameter) -> T {
        *self.parameter_mut(parameter)
    }

    /// Sets one parameter.
    pub fn set(&mut self, parameter: HealthParameter, value: T) {
        *self.parameter_mut(parameter) = value;
    }

    /// The same health with `delta` added to one parameter.
    ///
    /// ```
    /// use fd_jetengine::engine17::{Health, HealthParameter};
    ///
    /// let leaking = Health::default().shifted(HealthParameter::BleedLeak, 0.02);
    /// assert_eq!(leaking.bleed_leak, 0.02);
    /// ```
    #[must_use]
    pub fn shifted(mut self, parameter: HealthParameter, delta: T) -> Self
    where
        T: std::ops::AddAssign,
    {
        *self.parameter_mut(parameter) += delta;
        self
    }

    fn parameter_mut(&mut self, parameter: HealthParameter) -> &mut T {
        match parameter {
            HealthParameter::LpcEfficiency => &mut self.lpc_efficiency,
            HealthParameter::LpcFlow => &mut self.lpc_flow,
            HealthParameter::HpcEfficiency => &mut self.hpc_efficiency,
            HealthParameter::HpcFlow => &mut self.hpc_flow,
            HealthParameter::HptEfficiency => &mut self.hpt_efficiency,
            HealthParameter::HptFlow => &mut self.hpt_flow,
            HealthParameter::LptEfficiency => &mut self.lpt_efficiency,
            HealthParameter::LptFlow => &mut self.lpt_flow,
            HealthParameter::NozzleArea => &mut self.nozzle_area,
            HealthParameter::BleedLeak => &mut self.bleed_leak,
            HealthParameter::CoolingFlow => &mut self.cooling_flow,
            HealthParameter::CombustorEfficiency => &mut self.combustor_efficiency,
            HealthParameter::HeatingValue => &mut self.heating_value,
        }
    }
}
