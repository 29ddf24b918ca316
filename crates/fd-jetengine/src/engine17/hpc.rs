//! High-pressure compressor: flow from pressure ratio, with the bleeds behind it.

use fd_core::Scalar;

use super::{
    compressor::{Compression, speed_law},
    design::Design,
    gas::{Gas, k},
    health::Health,
    params::Parameters,
};

/// Constants of the component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hpc<T> {
    corrected_speed: T,
    corrected_flow: T,
    pressure_rise: T,
    efficiency: T,
    choke_flow: T,
    loading_exponent: T,
    surge_loading: T,
    flow_exponent: T,
    flow_curvature: T,
    pressure_exponent: T,
    pressure_curvature: T,
    efficiency_speed: T,
    efficiency_loading: T,
    best_speed: T,
}

/// What the compressor delivers.
#[derive(Clone, Copy, Debug)]
pub(super) struct HpcExit<T> {
    /// Pressure ratio.
    pub pi: T,
    /// Flow, kg/s.
    pub w_3: T,
    /// Delivery enthalpy, J/kg.
    pub h_3: T,
    /// Delivery temperature, K.
    pub t_3: T,
    /// Relative loading `y`: above the surge loading the compressor surges.
    pub y: T,
    /// Efficiency.
    pub efficiency: T,
}

impl<T: Scalar> Hpc<T> {
    pub(super) fn new(p: &Parameters, d: &Design) -> Self {
        let map = &p.hpc;
        Self {
            corrected_speed: k(d.hpc_corrected_speed),
            corrected_flow: k(d.hpc_corrected_flow),
            pressure_rise: k(d.pi_hpc - 1.0),
            efficiency: k(p.hpc_efficiency),
            choke_flow: k(map.choke_flow),
            loading_exponent: k(map.loading_exponent),
            surge_loading: k(map.surge_loading),
            flow_exponent: k(map.flow_exponent),
            flow_curvature: k(map.flow_curvature),
            pressure_exponent: k(map.pressure_exponent),
            pressure_curvature: k(map.pressure_curvature),
            efficiency_speed: k(map.efficiency_speed),
            efficiency_loading: k(map.efficiency_loading),
            best_speed: k(map.best_speed),
        }
    }

    /// Delivery at speed `n_h` (rpm) from `p_2` to `p_3` (kPa) at inlet `(t_2, h_2)`.
    #[allow(clippy::too_many_arguments, reason = "one argument per physical quantity")]
    pub(super) fn run(
        &self,
        air: &Gas<T>,
        health: &Health<T>,
        n_h: T,
        p_2: T,
        p_3: T,
        t_2: T,
        h_2: T,
    ) -> HpcExit<T> {
        let (one, zero) = (T::one(), T::zero());
        let square = |v: T| v * v;
        let root_theta = (t_2 / k(288.15)).sqrt();
        let n = n_h / root_theta / self.corrected_speed;
        let log_n = n.ln();
        let pi = p_3 / p_2;
        let reference_flow =
            speed_law(log_n, self.flow_exponent, self.flow_curvature) * health.hpc_flow;
        let psi = speed_law(log_n, self.pressure_exponent, self.pressure_curvature);

        let y = (pi - one) / (self.pressure_rise * psi);
        let x = self.choke_flow
            - (self.choke_flow - one) * y.max(zero).powf(self.loading_exponent)
            - k::<T>(0.5) * square((y - self.surge_loading).max(zero));
        let w_3 =
            x.max(k(0.02)) * reference_flow * self.corrected_flow * (p_2 / k(101.325)) / root_theta;
        let loss = self.efficiency_speed
            * (square(n - self.best_speed) - square(one - self.best_speed))
            + self.efficiency_loading * square(y - one);
        let efficiency = (self.efficiency * (one - loss)).max(k(0.3)) * health.hpc_efficiency;

        let exit = Compression::new(air, t_2, h_2, pi.max(k(1.0001)), efficiency);
        HpcExit { pi, w_3, h_3: exit.h, t_3: exit.t, y, efficiency }
    }
}
