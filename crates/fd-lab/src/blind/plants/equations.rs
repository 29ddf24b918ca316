//! A plant whose equations are plain functions of its parameters.

use super::plant::Physics;

/// A plant whose equations are plain functions of its parameters.
#[derive(Clone)]
struct Equations {
    p: Vec<f64>,
    laws: Laws,
}

pub(super) type Rates = fn(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]);

pub(super) type Outputs = fn(p: &[f64], x: &[f64], u: &[f64], y: &mut [f64]);

pub(super) type Motion = fn(x: &[f64], site: usize) -> [Option<f64>; 2];

pub(super) type Control =
    fn(p: &[f64], memory: &mut [f64], y: &[f64], reference: &[f64], u: &mut [f64]);

/// What they are.
#[derive(Clone, Copy)]
pub(super) struct Laws {
    pub rates: Rates,
    pub outputs: Outputs,
    pub motion: Motion,
    pub control: Control,
    pub memory: usize,
}

impl Laws {
    pub(super) const fn open(rates: Rates, outputs: Outputs, motion: Motion) -> Self {
        Self { rates, outputs, motion, control: no_control, memory: 0 }
    }

    pub(super) fn at(self, p: &[f64]) -> Box<dyn Physics> {
        Box::new(Equations { p: p.to_vec(), laws: self })
    }
}

/// Without a controller the references are the commands.
fn no_control(_: &[f64], _: &mut [f64], _: &[f64], reference: &[f64], u: &mut [f64]) {
    u.copy_from_slice(reference);
}

impl Physics for Equations {
    fn set(&mut self, p: &[f64]) {
        self.p.copy_from_slice(p);
    }

    fn rates(&self, x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
        (self.laws.rates)(&self.p, x, u, f, dx);
    }

    fn outputs(&self, x: &[f64], u: &[f64], y: &mut [f64]) {
        (self.laws.outputs)(&self.p, x, u, y);
    }

    fn motion(&self, x: &[f64], site: usize) -> [Option<f64>; 2] {
        (self.laws.motion)(x, site)
    }

    fn control(&self, memory: &mut [f64], y: &[f64], reference: &[f64], u: &mut [f64]) {
        (self.laws.control)(&self.p, memory, y, reference, u);
    }

    fn memory(&self) -> usize {
        self.laws.memory
    }
}
