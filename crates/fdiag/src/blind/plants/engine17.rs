//! The nonlinear engine of 17 states, with a linear model of five states for its simulator.

use std::fmt::Write as _;

use fd_gap::model::Model;
use fd_jetengine::engine17::{Engine17, NX, Parameters};
use fd_model::reduce::residualise_onto;

use super::{Physics, Plant, parse};
use crate::blind::{error::BlindError, excitation::Drive};

/// Fuel flow about which everything is a deviation, in kg/s.
const FUEL: f64 = 0.712;
/// States of the model: both speeds, and the slowest of the gas path.
const KEPT: [usize; 5] = [0, 1, 16, 8, 5];
/// Their names.
const NAMES: [&str; 5] = ["n_l", "n_h", "t_7", "p_6", "t_4"];
/// How many of them are measured.
const MEASURED: usize = 4;

pub(super) const ENGINE17: Plant = Plant {
    name: "engine17",
    model,
    physics,
    drives: &[Drive { centre: 0.0, amplitude: 0.015, band: [0.02, 0.4] }],
    noise_in_loop: false,
    step: 0.0025,
    reverses: false,
    weight: 5,
};

/// Per-unit deviations: the shafts are a little faster or slower than known, `r_l` and `r_h`.
fn model() -> Result<Model, BlindError> {
    let engine = Engine17::<f64>::new(&Parameters::default())?;
    let linear = engine.linearise(&engine.trim(FUEL)?)?.per_unit()?.model;
    let reduced = residualise_onto(&linear, &KEPT)?;
    let mut text = String::from(
        "version = 1\nkind = \"equations\"\nname = \"engine17\"\n\
         description = \"Turbofan near one operating point: 17 states, residualised to 5; \
         per-unit deviations\"\n\
         sample_time = 0.05\n\
         [parameters]\n\
         r_l = { unit = \"1\", value = 1.0, bounds = [0.1, 10.0] }\n\
         r_h = { unit = \"1\", value = 1.0, bounds = [0.1, 10.0] }\n\
         k_f = { unit = \"1\", value = 1.0, tolerance = 0.001, bounds = [0.1, 10.0] }\n\
         [inputs]\nfuel = { unit = \"1\", saturation = [-0.5, 0.5] }\n[states]\n",
    );
    for (i, name) in NAMES.iter().enumerate() {
        let factor = ["r_l*", "r_h*", "", "", ""][i];
        let mut sum = format!("{:e}*k_f*fuel", reduced.b()[(i, 0)]);
        for (j, other) in NAMES.iter().enumerate() {
            let _ = write!(sum, " + {:e}*{other}", reduced.a()[(i, j)]);
        }
        let _ = writeln!(
            text,
            "{name} = {{ unit = \"1\", initial = 0.0, tolerance = 0.0005, \
             derivative = \"{factor}({sum})\" }}",
        );
    }
    text += "[outputs]\n";
    for name in &NAMES[..MEASURED] {
        let _ = writeln!(
            text,
            "{} = {{ unit = \"1\", value = \"{name}\", noise = 0.0005 }}",
            name.to_uppercase(),
        );
    }
    text += "[sites]\n\
             shaft_l = { unit = \"1/s\", enters = { n_l = \"r_l\" }, velocity = \"n_l\" }\n\
             shaft_h = { unit = \"1/s\", enters = { n_h = \"r_h\" }, velocity = \"n_h\" }\n";
    parse(&text, "engine17")
}

struct Turbofan {
    engine: Engine17<f64>,
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

    /// States, inputs and forces are per-unit deviations from the trim point.
    fn rates(&self, x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
        let mut physical = self.trim;
        for ((physical, trim), x) in physical.iter_mut().zip(&self.trim).zip(x) {
            *physical = trim * (1.0 + x);
        }
        let rates = self.engine.rhs(&physical, FUEL * (1.0 + self.p[2] * u[0]));
        for ((dx, rate), trim) in dx.iter_mut().zip(rates).zip(&self.trim) {
            *dx = rate / trim;
        }
        dx[0] += self.p[0] * f[0];
        dx[1] += self.p[1] * f[1];
    }

    fn outputs(&self, x: &[f64], _: &[f64], y: &mut [f64]) {
        for (y, state) in y.iter_mut().zip(KEPT) {
            *y = x[state];
        }
    }

    fn begin(&self, x0: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; NX];
        x0.iter().zip(KEPT).for_each(|(x0, state)| x[state] = *x0);
        x
    }

    fn motion(&self, x: &[f64], site: usize) -> [Option<f64>; 2] {
        [None, Some(x[site])]
    }

    fn control(&self, _: &mut [f64], _: &[f64], reference: &[f64], u: &mut [f64]) {
        u.copy_from_slice(reference);
    }
}
