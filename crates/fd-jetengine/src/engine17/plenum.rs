//! Volumes that store mass and energy, and ducts that store momentum.

use fd_core::Scalar;

use super::gas::{GAS_CONSTANT, Gas, k};

/// A well-mixed volume.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plenum<T> {
    volume: T,
}

/// Rates of a plenum.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlenumRates<T> {
    /// kPa/s.
    pub p: T,
    /// K/s.
    pub t: T,
}

impl<T: Scalar> Plenum<T> {
    pub(super) fn new(volume: f64) -> Self {
        Self { volume: k(volume) }
    }

    /// Mass and energy balance of a plenum at `(p, t)` (kPa, K) with inflows `(W, h)`, outflow
    /// `w_out` (kg/s) and heat `q` (W), with `m = P V / R T` and `u = h(T) - R T`:
    ///
    /// `Ṫ = [Σ W (h_i - u) + q - W_o R T] / (m c_v)`, `Ṗ = (R / V) [T (Σ W - W_o) + m Ṫ]`.
    pub(super) fn rates<const N: usize>(
        &self,
        gas: &Gas<T>,
        p: T,
        t: T,
        inflows: [(T, T); N],
        w_out: T,
        q: T,
    ) -> PlenumRates<T> {
        let r = k::<T>(GAS_CONSTANT);
        let mass = p * k(1e3) * self.volume / (r * t);
        let cv = gas.cp(t) - r;
        let u = gas.enthalpy(t) - r * t;
        let mut w_in = T::zero();
        let mut energy = q - w_out * r * t;
        for (w, h) in inflows {
            w_in += w;
            energy += w * (h - u);
        }
        let t_rate = energy / (mass * cv);
        PlenumRates {
            p: r / self.volume * (t * (w_in - w_out) + mass * t_rate) * k(1e-3),
            t: t_rate,
        }
    }

    /// Mass balance of a plenum whose temperature follows at once, with γ = 1.4, in kPa/s.
    pub(super) fn pressure_rate(&self, t: T, w_in: T, w_out: T) -> T {
        k::<T>(1.4 * GAS_CONSTANT * 1e-3) * t / self.volume * (w_in - w_out)
    }
}

/// A duct of one-dimensional flow with a quadratic loss.
#[derive(Clone, Copy, Debug)]
pub(super) struct Duct<T> {
    /// Cross-section over length, in m, times 1000 Pa/kPa.
    area_over_length: T,
    loss: T,
}

impl<T: Scalar> Duct<T> {
    pub(super) fn new(area_over_length: f64, loss: f64) -> Self {
        Self { area_over_length: k(1e3 * area_over_length), loss: k(loss) }
    }

    /// `Ẇ = (A / L) (P_up - P_down - k W |W| T / P_up)`, kg/s², for pressures in kPa.
    pub(super) fn flow_rate(&self, p_up: T, p_down: T, w: T, t: T) -> T {
        self.area_over_length * (p_up - p_down - self.loss * w * w.abs() * t / p_up)
    }
}
