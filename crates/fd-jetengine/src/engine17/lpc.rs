//! Low-pressure compressor: pressure ratio from flow, by a Moore-Greitzer cubic.

use fd_core::Scalar;

use super::{
    compressor::{Compression, speed_law},
    design::Design,
    environment::{Environment, Inlet},
    gas::{Gas, k},
    health::Health,
    params::Parameters,
};

/// Constants of the component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lpc<T> {
    corrected_speed: T,
    corrected_flow: T,
    pressure_rise: T,
    outer_stream: T,
    efficiency: T,
    psi_0: T,
    cubic_height: T,
    peak_flow: T,
    flow_exponent: T,
    flow_curvature: T,
    pressure_exponent: T,
    pressure_curvature: T,
    efficiency_speed: T,
    efficiency_flow: T,
    best_speed: T,
    /// Effect of the guide vanes on flow and pressure rise.
    vane_flow: T,
    vane_pressure: T,
}

/// What the compressor delivers.
#[derive(Clone, Copy, Debug)]
pub(super) struct LpcExit<T> {
    /// Pressure ratio of the core stream.
    pub pi: T,
    /// Core stream: delivery pressure (kPa), enthalpy (J/kg), temperature (K).
    pub p_13: T,
    pub h_2: T,
    pub t_2: T,
    /// Outer stream: delivery pressure (kPa), enthalpy (J/kg), temperature (K).
    pub p_b: T,
    pub h_b: T,
    pub t_b: T,
    /// Relative flow `x`: below the peak of the cubic the compressor surges.
    pub x: T,
    /// Efficiency.
    pub efficiency: T,
}

impl<T: Scalar> Lpc<T> {
    pub(super) fn new(p: &Parameters, d: &Design, environment: &Environment) -> Self {
        let map = &p.lpc;
        Self {
            corrected_speed: k(d.lpc_corrected_speed),
            corrected_flow: k(d.lpc_corrected_flow),
            pressure_rise: k(d.pi_lpc - 1.0),
            outer_stream: k(p.outer_stream),
            efficiency: k(p.lpc_efficiency),
            psi_0: k(d.psi_0),
            cubic_height: k(map.cubic_height),
            peak_flow: k(map.peak_flow),
            flow_exponent: k(map.flow_exponent),
            flow_curvature: k(map.flow_curvature),
            pressure_exponent: k(map.pressure_exponent),
            pressure_curvature: k(map.pressure_curvature),
            efficiency_speed: k(map.efficiency_speed),
            efficiency_flow: k(map.efficiency_flow),
            best_speed: k(map.best_speed),
            vane_flow: k(1.0 + map.vane_flow * environment.guide_vanes),
            vane_pressure: k(1.0 + map.vane_pressure * environment.guide_vanes),
        }
    }

    /// Delivery at speed `n_l` (rpm) and total flow `w` (kg/s).
    pub(super) fn run(
        &self,
        air: &Gas<T>,
        inlet: &Inlet<T>,
        health: &Health<T>,
        n_l: T,
        w: T,
    ) -> LpcExit<T> {
        let one = T::one();
        let n = n_l / inlet.root_theta / self.corrected_speed;
        let log_n = n.ln();
        let flow = w * inlet.root_theta / inlet.delta / self.corrected_flow;
        let reference_flow = speed_law(log_n, self.flow_exponent, self.flow_curvature)
            * health.lpc_flow
            * self.vane_flow;
        let psi =
            speed_law(log_n, self.pressure_exponent, self.pressure_curvature) * self.vane_pressure;
        let x = flow / reference_flow;

        let z = x / (self.peak_flow * k(0.5)) - one;
        let cubic =
            self.psi_0 + self.cubic_height * (one + z * (k::<T>(1.5) - k::<T>(0.5) * z * z));
        let pi = (one + self.pressure_rise * psi * cubic).max(k(0.5));
        let square = |v: T| v * v;
        let loss = self.efficiency_speed
            * (square(n - self.best_speed) - square(one - self.best_speed))
            + self.efficiency_flow * square(x - one);
        let efficiency = (self.efficiency * (one - loss)).max(k(0.3)) * health.lpc_efficiency;

        let core = Compression::new(air, inlet.t_1, inlet.h_1, pi, efficiency);
        let pi_b = (one + (pi - one) * self.outer_stream).max(k(0.5));
        let outer = Compression::new(air, inlet.t_1, inlet.h_1, pi_b, efficiency);
        LpcExit {
            pi,
            p_13: inlet.p_1 * pi,
            h_2: core.h,
            t_2: core.t,
            p_b: inlet.p_1 * pi_b,
            h_b: outer.h,
            t_b: outer.t,
            x,
            efficiency,
        }
    }
}
