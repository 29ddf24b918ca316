//! Combustor: pressure loss and the heat that the fuel brings.

use fd_core::Scalar;

use super::{design::Design, gas::k, health::Health, params::Parameters};

/// Constants of the component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Combustor<T> {
    loss: T,
    heat: T,
    fuel_enthalpy: T,
}

impl<T: Scalar> Combustor<T> {
    pub(super) fn new(p: &Parameters, d: &Design) -> Self {
        Self {
            loss: k(d.combustor_loss),
            heat: k(p.combustor_efficiency * p.heating_value),
            fuel_enthalpy: k(p.fuel_enthalpy),
        }
    }

    /// Pressure behind the combustor in kPa, for an air flow `w_a` (kg/s) at `(p_3, t_3)`.
    pub(super) fn exit_pressure(&self, w_a: T, p_3: T, t_3: T) -> T {
        p_3 * (T::one() - self.loss * w_a * w_a * t_3 / (p_3 * p_3))
    }

    /// Enthalpy that one kg of fuel brings, J/kg.
    pub(super) fn fuel_heat(&self, health: &Health<T>) -> T {
        self.fuel_enthalpy + health.combustor_efficiency * self.heat * health.heating_value
    }
}

/// Fuel-air ratio within the range of the gas properties, 0 to 0.06; the floor on the air keeps
/// the quotient finite while the integrator probes absurd states.
pub(super) fn fuel_air_ratio<T: Scalar>(fuel: T, air: T, least_air: f64) -> T {
    (fuel / air.max(k(least_air))).max(T::zero()).min(k(0.06))
}
