//! Adiabatic compression with an isentropic efficiency, shared by both compressors.

use fd_core::Scalar;

use super::gas::Gas;

/// State of the air after a compression.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compression<T> {
    /// Enthalpy, J/kg.
    pub h: T,
    /// Temperature, K.
    pub t: T,
}

impl<T: Scalar> Compression<T> {
    /// Compresses from `(t, h)` by `pressure_ratio`.
    #[inline]
    pub(super) fn new(air: &Gas<T>, t: T, h: T, pressure_ratio: T, efficiency: T) -> Self {
        let ideal = air.isentropic(t, pressure_ratio);
        let h = h + (air.enthalpy(ideal) - h) / efficiency;
        Self { h, t: air.temperature_of_enthalpy(h, ideal) }
    }
}

/// `exp(a ln n - c ln² n)`: how flow or pressure rise follows the relative speed.
#[inline]
pub(super) fn speed_law<T: Scalar>(log_speed: T, a: T, c: T) -> T {
    (a * log_speed - c * log_speed * log_speed).exp()
}
