//! Turbines: flow from an ellipse over the pressure ratio, work from an efficiency.

use fd_core::Scalar;

use super::{
    gas::{Gas, k},
    params::TurbineMap,
};

/// Constants of one turbine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turbine<T> {
    flow: T,
    efficiency: T,
    reference_speed: T,
    critical_ratio: T,
    curvature: T,
}

/// What passes the turbine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expansion<T> {
    /// Flow, kg/s.
    pub w: T,
    /// Enthalpy at the exit, J/kg.
    pub h: T,
}

/// Gas at the inlet of a turbine.
#[derive(Clone, Copy, Debug)]
pub(super) struct TurbineInlet<'a, T> {
    pub gas: &'a Gas<T>,
    /// Pressure, kPa.
    pub p: T,
    /// Temperature, K.
    pub t: T,
    /// Enthalpy, J/kg.
    pub h: T,
}

impl<T: Scalar> Turbine<T> {
    /// `flow`, `efficiency` and `speed` are the reference values of the design.
    pub(super) fn new(map: TurbineMap, flow: f64, efficiency: f64, speed: f64) -> Self {
        Self {
            flow: k(flow),
            efficiency: k(efficiency),
            reference_speed: k(speed),
            critical_ratio: k(map.critical_ratio),
            curvature: k(map.efficiency_curvature),
        }
    }

    /// Expansion to `p_exit` (kPa) at shaft speed `n` (rpm); the two factors are health.
    pub(super) fn run(
        &self,
        inlet: &TurbineInlet<'_, T>,
        n: T,
        p_exit: T,
        flow_factor: T,
        efficiency_factor: T,
    ) -> Expansion<T> {
        let ratio = p_exit / inlet.p;
        let root_t = inlet.t.sqrt();
        let w = flow_factor * self.flow * inlet.p / root_t * ellipse(ratio, self.critical_ratio);
        let speed = n / root_t / self.reference_speed - T::one();
        let efficiency =
            self.efficiency * (T::one() - self.curvature * speed * speed) * efficiency_factor;
        let ideal = inlet.gas.isentropic(inlet.t, ratio.min(k(0.9999)));
        Expansion { w, h: inlet.h - efficiency * (inlet.h - inlet.gas.enthalpy(ideal)) }
    }
}

/// Flow parameter over the ratio of exit to inlet pressure: 1 when choked, 0 without a drop.
pub(super) fn ellipse<T: Scalar>(ratio: T, critical: T) -> T {
    let z = (ratio.max(critical) - critical) / (T::one() - critical);
    (T::one() - z * z).max(k(1e-10)).sqrt()
}
