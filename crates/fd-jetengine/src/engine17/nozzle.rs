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
    gamma: T,
    critical_ratio: T,
}

impl<T: Scalar> PipeGas<T> {
    fn new(t: T, gamma: T) -> Self {
        let one = T::one();
        Self {
            root_rt: (k::<T>(GAS_CONSTANT) * t).sqrt(),
            gamma,
            critical_ratio: (k::<T>(2.0) / (gamma + one)).powf(gamma / (gamma - one)),
        }
    }

    /// Total pressure (kPa) of a flow `w` through `area` (m²) at static pressure `ps` (kPa).
    fn total_pressure(&self, ps: T, w: T, area: T) -> T {
        let one = T::one();
        let below_one = self.gamma - one;
        let q = w * self.root_rt / (area * ps * k(1e3));
        let q = q * q / self.gamma;
        let mach_squared = k::<T>(2.0) * q / (one + (one + k::<T>(2.0) * below_one * q).sqrt());
        ps * (one + k::<T>(0.5) * below_one * mach_squared).powf(self.gamma / below_one)
    }

    /// Flow per throat area, kg/(s m²), from total pressure `pt` to ambient `pa` (kPa).
    fn flow_density(&self, pt: T, pa: T) -> T {
        let one = T::one();
        let ratio = (pa / pt).max(self.critical_ratio);
        if ratio >= one {
            return T::zero();
        }
        let g = self.gamma;
        let head = ratio.powf(k::<T>(2.0) / g) - ratio.powf((g + one) / g);
        pt * k(1e3) / self.root_rt * (k::<T>(2.0) * g / (g - one) * head).sqrt()
    }
}

impl<T: Scalar> Nozzle<T> {
    pub(super) fn new(throat: f64, pipe: f64) -> Self {
        Self { throat: k(throat), pipe: k(pipe) }
    }

    /// Jet at static pressure `ps` (kPa), temperature `t` (K) and heat capacity `cp` (J/(kg K))
    /// in the jet pipe, ambient pressure `pa` (kPa), with a factor on the throat area.
    pub(super) fn run(&self, ps: T, t: T, cp: T, pa: T, area_factor: T) -> Jet<T> {
        let one = T::one();
        let gamma = cp / (cp - k(GAS_CONSTANT));
        let gas = PipeGas::new(t, gamma);
        let throat = self.throat * area_factor;
        let mut pt_7 = ps * k(1.05);
        let mut w_8 = T::zero();
        for _ in 0..PASSES {
            w_8 = throat * gas.flow_density(pt_7, pa);
            pt_7 = gas.total_pressure(ps, w_8, self.pipe);
        }
        let p_8 = pa.max(pt_7 * gas.critical_ratio);
        let drop = one - (p_8 / pt_7).powf((gamma - one) / gamma);
        let speed = (k::<T>(2.0) * cp * t * drop).max(T::zero()).sqrt();
        Jet { w_8, pt_7, thrust: w_8 * speed + throat * (p_8 - pa) * k(1e3) }
    }
}

impl Nozzle<f64> {
    /// Throat area in m² that passes `w` (kg/s) from the jet-pipe state.
    pub(super) fn area_for(w: f64, ps: f64, t: f64, gamma: f64, pa: f64, pipe: f64) -> f64 {
        let gas = PipeGas::new(t, gamma);
        w / gas.flow_density(gas.total_pressure(ps, w, pipe), pa)
    }
}
