//! The nonlinear engine of 17 states, with a linear model of three modes for its simulator.

use fd_jetengine::engine17::{Engine17, NX, Parameters};

use super::plant::{Physics, Plant, parse};
use crate::blind::{error::BlindError, excitation::Drive};

const MODEL: &str = include_str!("engine17.toml");

/// Fuel flow about which everything is a deviation, in kg/s.
const FUEL: f64 = 0.712;
/// State of the exhaust temperature; the thermocouple comes after the engine's own states.
const T_7: usize = 16;

pub(super) const ENGINE17: Plant = Plant {
    name: "engine17",
    model: || parse(MODEL, "engine17.toml"),
    physics,
    drives: &[Drive { centre: 0.0, amplitude: 0.02, band: [0.02, 0.4] }],
    noise_in_loop: false,
    step: 0.005,
    reverses: false,
    weight: 5,
};

struct Turbofan {
    engine: Engine17<f64>,
    /// `r_l`, `r_h`, `k_f`, `T_s`: the shafts are a little lighter or heavier than known, the fuel
    /// meter and the thermocouple a little wrong.
    p: Vec<f64>,
    trim: [f64; NX],
}

fn physics(p: &[f64]) -> Result<Box<dyn Physics>, BlindError> {
    let engine = engine_of(p)?;
    let trim = engine.trim(FUEL)?.x;
    Ok(Box::new(Turbofan { engine, p: p.to_vec(), trim }))
}

fn engine_of(p: &[f64]) -> Result<Engine17<f64>, BlindError> {
    let mut parameters = Parameters::default();
    parameters.inertia_l /= p[0];
    parameters.inertia_h /= p[1];
    Ok(Engine17::new(&parameters)?)
}

impl Physics for Turbofan {
    fn set(&mut self, p: &[f64]) {
        if p[..2] != self.p[..2]
            && let Ok(engine) = engine_of(p)
        {
            self.engine = engine;
        }
        self.p.copy_from_slice(p);
    }

    /// States, inputs and forces are per-unit deviations from the trim point; the trim does not
    /// depend on the inertias.
    fn rates(&self, x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
        let mut physical = self.trim;
        for ((physical, trim), x) in physical.iter_mut().zip(&self.trim).zip(x) {
            *physical = trim * (1.0 + x);
        }
        let rates = self.engine.rhs(&physical, FUEL * (1.0 + self.p[2] * u[0]));
        for ((dx, rate), trim) in dx.iter_mut().zip(rates).zip(&self.trim) {
            *dx = rate / trim;
        }
        dx[0] += f[0];
        dx[1] += f[1];
        dx[NX] = (x[T_7] - x[NX]) / self.p[3];
    }

    fn outputs(&self, x: &[f64], _: &[f64], y: &mut [f64]) {
        y.copy_from_slice(&[x[0], x[1], x[NX]]);
    }

    /// Both shafts, the gas path in its steady state, and the thermocouple.
    fn begin(&self, x0: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; NX + 1];
        (x[0], x[1], x[NX]) = (x0[0], x0[1], x0[3]);
        x
    }

    fn motion(&self, x: &[f64], site: usize) -> [Option<f64>; 2] {
        [None, Some(x[site])]
    }

    fn control(&self, _: &mut [f64], _: &[f64], reference: &[f64], u: &mut [f64]) {
        u.copy_from_slice(reference);
    }
}
