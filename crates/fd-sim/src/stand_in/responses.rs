//! A simulator of which only outputs can be seen, as the responses of these to everything that can be moved.

use std::sync::Arc;

use super::replayed::Linear;
use crate::simulate::{Changes, DifferenceEquation};

/// Responses of the outputs of a simulator: difference equations for inputs and forces, the same at all times, and
/// whole runs for parameters and initial states.
#[derive(Clone, Debug)]
pub(super) struct Responses {
    known: Arc<Known>,
    /// By how much parameters and initial states are moved.
    moved: Vec<f64>,
    x0: Vec<f64>,
    /// What inputs and forces change.
    changes: Changes,
    /// By how much they are others than in the replays, and what that changes now.
    w: Vec<f64>,
    change: Vec<f64>,
    /// Whether the run began where a replay does.
    is_at_home: bool,
    next: Option<usize>,
}

/// What is known of a simulator.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub theta: Vec<f64>,
    pub x0: Vec<f64>,
    /// Inputs, forces and outputs of the replays, row by row.
    pub u: Vec<f64>,
    pub f: Vec<f64>,
    pub y: Vec<f64>,
    /// First rows of the replays.
    pub begins: Vec<usize>,
    /// Change of the outputs per parameter and per initial state, row by row.
    pub runs: Vec<Vec<f64>>,
    /// The difference equation of each output.
    pub equations: Arc<[DifferenceEquation]>,
}

impl Responses {
    pub(super) fn new(known: Known) -> Self {
        let (x0, moved) = (known.x0.clone(), vec![0.0; known.runs.len()]);
        let driven = known.equations.first().map_or(0, |e| e.b.len());
        Self {
            moved,
            x0,
            changes: Changes::new(Arc::clone(&known.equations)),
            w: vec![0.0; driven],
            change: vec![0.0; known.equations.len()],
            is_at_home: true,
            next: None,
            known: Arc::new(known),
        }
    }

    /// Looks what inputs and forces change at a row.
    fn look(&mut self, row: usize, u: &[f64], f: &[f64]) {
        // What is known begins with the replays and goes on row by row.
        self.is_at_home &= match self.next {
            None => self.known.begins.contains(&row),
            Some(next) => next == row,
        };
        let (nu, nf) = (u.len(), f.len());
        let known = &self.known.u[row * nu..(row + 1) * nu];
        self.w[..nu].iter_mut().zip(u.iter().zip(known)).for_each(|(w, (u, known))| *w = u - known);
        let known = &self.known.f[row * nf..(row + 1) * nf];
        let forces = self.w[nu..nu + nf].iter_mut();
        forces.zip(f.iter().zip(known)).for_each(|(w, (f, known))| *w = f - known);
        self.change.copy_from_slice(self.changes.of(&self.w));
    }

    fn outputs(&self, row: usize, y: &mut [f64]) {
        if !self.is_at_home {
            y.fill(f64::NAN);
            return;
        }
        let ny = y.len();
        let rows = row * ny..(row + 1) * ny;
        y.copy_from_slice(&self.known.y[rows.clone()]);
        y.iter_mut().zip(&self.change).for_each(|(y, change)| *y += change);
        for (moved, run) in
            self.moved.iter().zip(&self.known.runs).filter(|(moved, _)| **moved != 0.0)
        {
            y.iter_mut().zip(&run[rows.clone()]).for_each(|(y, slope)| *y += moved * slope);
        }
    }
}

impl Linear for Responses {
    fn rows(&self) -> usize {
        self.known.y.len() / self.known.equations.len().max(1)
    }

    fn start(&mut self, theta: &[f64], x0: &[f64]) {
        let now = theta.iter().chain(x0);
        let nominal = self.known.theta.iter().chain(&self.known.x0);
        self.moved.iter_mut().zip(now.zip(nominal)).for_each(|(d, (p, p0))| *d = p - p0);
        self.x0.copy_from_slice(x0);
        self.changes.rest();
        (self.is_at_home, self.next) = (true, None);
    }

    fn measure(&mut self, row: usize, u: &[f64], f: &[f64], y: &mut [f64]) {
        self.look(row, u, f);
        self.outputs(row, y);
    }

    fn step(&mut self, row: usize, u: &[f64], f: &[f64], y: &mut [f64]) {
        self.measure(row, u, f, y);
        self.changes.move_on();
        self.next = Some(row + 1);
    }

    fn state(&self) -> &[f64] {
        &self.x0
    }

    fn go_on_from(&mut self, _x: &[f64]) -> bool {
        false
    }
}
