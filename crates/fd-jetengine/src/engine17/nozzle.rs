//! Convergent nozzle behind a jet pipe whose state is its static pressure.

use fd_core::Scalar;

use super::gas::{GAS_CONSTANT, k};

/// Passes of the fixed-point iteration between flow and total pressure; fixed for the same
/// reason as Newton's in the gas properties.
const PASSES: usize = 6;

/// Constants of the component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nozzle<T> {
    throat: T,
    pipe: T,
}

/// What leaves the nozzle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet<T> {
    /// Flow, kg/s.
    pub w_8: T,
    /// Total pressure in the jet pipe, kPa.
    pub pt_7: T,
    /// Gross thrust, N.
    pub thrust: T,
}

/// Gas in the jet pipe: what the compressible-flow relations need of it.
#[derive(Clone, Copy, Debug)]
struct PipeGas<T> {
    root_rt: T,
    /// `γ`, `γ - 1` and `γ / (γ - 1)`.
    gamma: T,
    below_one: T,
    exponent: T,
}

/// The throat of the nozzle.
#[derive(Clone, Copy, Debug)]
struct Throat<T> {
    /// Static pressure, kPa.
    p: T,
    /// Static over total temperature.
    cooling: T,
}

/// Pressures change as the power `γ / (γ - 1)` of temperatures. Temperatures are cheap, so that
/// the iteration between flow and total pressure is one between flow and total temperature; its
/// powers are left to where a pressure is needed.
impl<T: Scalar> PipeGas<T> {
    fn new(t: T, gamma: T) -> Self {
        let below_one = gamma - T::one();
        let root_rt = (k::<T>(GAS_CONSTANT) * t).sqrt();
        Self { root_rt, gamma, below_one, exponent: gamma / below_one }
    }

    /// Ratio of temperatures of a ratio of pressures.
    fn temperature_ratio(&self, pressure_ratio: T) -> T {
        pressure_ratio.powf(self.below_one / self.gamma)
    }

    /// Ratio of pressures of a ratio of temperatures.
    fn pressure_ratio(&self, temperature_ratio: T) -> T {
        temperature_ratio.powf(self.exponent)
    }

    /// Total over static temperature of a flow `w` through `area` (m²) at static pressure `ps`
    /// (kPa): `1 + (γ - 1) / 2 M²`.
    fn heating(&self, ps: T, w: T, area: T) -> T {
        let one = T::one();
        let q = w * self.root_rt / (area * ps * k(1e3));
        let q = q * q / self.gamma;
        let root = (one + k::<T>(2.0) * self.below_one * q).sqrt();
        one + self.below_one * q / (one + root)
    }

    /// The throat to ambient pressure `pa`, from static pressure `ps` (kPa) with total over static
    /// temperature `heating`, when expanding from `ps` to `pa` cools to `cooling`.
    fn throat(&self, ps: T, heating: T, pa: T, cooling: T) -> Throat<T> {
        let sonic = k::<T>(2.0) / (self.gamma + T::one());
        let cooling = cooling / heating;
        if cooling <= sonic {
            Throat { p: ps * self.pressure_ratio(heating * sonic), cooling: sonic }
        } else {
            Throat { p: pa, cooling }
        }
    }

    /// Flow per throat area, kg/(s m²): `p / θ √(2 γ / (γ - 1) (1 - θ) / R T_t)`.
    fn flow_density(&self, throat: &Throat<T>) -> T {
        let head = k::<T>(2.0) * self.exponent * (T::one() - throat.cooling);
        k::<T>(1e3) * throat.p / throat.cooling * head.max(T::zero()).sqrt() / self.root_rt
    }
}

impl<T: Scalar> Nozzle<T> {
    pub(super) fn new(throat: f64, pipe: f64) -> Self {
        Self { throat: k(throat), pipe: k(pipe) }
    }

    /// Jet at static pressure `ps` (kPa), temperature `t` (K) and heat capacity `cp` (J/(kg K))
    /// in the jet pipe, ambient pressure `pa` (kPa), with a factor on the throat area.
    pub(super) fn run(&self, ps: T, t: T, cp: T, pa: T, area_factor: T) -> Jet<T> {
        let gas = PipeGas::new(t, cp / (cp - k(GAS_CONSTANT)));
        let area = self.throat * area_factor;
        let cooling = gas.temperature_ratio(pa / ps);
        let mut heating = gas.temperature_ratio(k(1.05));
        let mut w_8 = T::zero();
        for _ in 0..PASSES {
            w_8 = area * gas.flow_density(&gas.throat(ps, heating, pa, cooling));
            heating = gas.heating(ps, w_8, self.pipe);
        }
        let throat = gas.throat(ps, heating, pa, cooling);
        let drop = T::one() - throat.cooling;
        let speed = (k::<T>(2.0) * cp * t * drop).max(T::zero()).sqrt();
        Jet {
            w_8,
            pt_7: ps * gas.pressure_ratio(heating),
            thrust: w_8 * speed + area * (throat.p - pa) * k(1e3),
        }
    }
}

impl Nozzle<f64> {
    /// Throat area in m² that passes `w` (kg/s) from the jet-pipe state.
    pub(super) fn area_for(w: f64, ps: f64, t: f64, gamma: f64, pa: f64, pipe: f64) -> f64 {
        let gas = PipeGas::new(t, gamma);
        let cooling = gas.temperature_ratio(pa / ps);
        w / gas.flow_density(&gas.throat(ps, gas.heating(ps, w, pipe), pa, cooling))
    }
}
