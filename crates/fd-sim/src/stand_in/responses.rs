//! A simulator of which only outputs can be seen, as the responses of these to everything that can be moved.

use std::sync::Arc;

use super::replayed::Linear;

/// Responses of the outputs of a simulator: difference equations for inputs and forces, the same at all times, and
/// whole runs for parameters and initial states.
#[derive(Clone, Debug)]
pub(super) struct Responses {
    known: Arc<Known>,
    /// By how much parameters and initial states are moved.
    moved: Vec<f64>,
    x0: Vec<f64>,
    /// The last changes of each output that inputs and forces have made, the newest first.
    past_y: Vec<Vec<f64>>,
    /// The changes of all inputs and forces now, and before, the newest first.
    w: Vec<f64>,
    changes: Vec<f64>,
    /// Whether the run began where a replay does.
    is_at_home: bool,
    next: Option<usize>,
}

/// What is known of a simulator.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub(super) theta: Vec<f64>,
    pub(super) x0: Vec<f64>,
    /// Inputs, forces and outputs of the replays, row by row.
    pub(super) u: Vec<f64>,
    pub(super) f: Vec<f64>,
    pub(super) y: Vec<f64>,
    /// First rows of the replays.
    pub(super) begins: Vec<usize>,
    /// Change of the outputs per parameter and per initial state, row by row.
    pub(super) runs: Vec<Vec<f64>>,
    /// The difference equation of each output.
    pub(super) equations: Vec<Equation>,
}

/// `y(k) = Σ a_i y(k−i) + Σ_j Σ b_ji w_j(k−i)`, of changes.
#[derive(Clone, Debug)]
pub(super) struct Equation {
    pub(super) a: Vec<f64>,
    /// Per input and force, from `i = 0` on.
    pub(super) b: Vec<Vec<f64>>,
}

impl Equation {
    /// The next change, from those before, the newest first; `w` begins with what drives it now.
    pub(super) fn next(&self, past_y: &[f64], w: &[f64]) -> f64 {
        let own: f64 = self.a.iter().zip(past_y).map(|(a, y)| a * y).sum();
        let driven = |(j, b): (usize, &Vec<f64>)| -> f64 {
            b.iter().zip(w[j..].iter().step_by(self.b.len())).map(|(b, w)| b * w).sum()
        };
        own + self.b.iter().enumerate().map(driven).sum::<f64>()
    }
}

impl Responses {
    pub(super) fn new(known: Known) -> Self {
        let (x0, moved) = (known.x0.clone(), vec![0.0; known.runs.len()]);
        let order = known.equations.iter().map(|e| e.a.len()).max().unwrap_or(0);
        let driven = known.equations.first().map_or(0, |e| e.b.len());
        Self {
            moved,
            x0,
            past_y: vec![vec![0.0; order]; known.equations.len()],
            w: vec![0.0; driven * (order + 1)],
            changes: vec![0.0; known.equations.len()],
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
        let equations = self.known.equations.iter().zip(&self.past_y);
        for (change, (equation, past)) in self.changes.iter_mut().zip(equations) {
            *change = equation.next(past, &self.w);
        }
    }

    fn outputs(&self, row: usize, y: &mut [f64]) {
        if !self.is_at_home {
            y.fill(f64::NAN);
            return;
        }
        let ny = y.len();
        let rows = row * ny..(row + 1) * ny;
        y.copy_from_slice(&self.known.y[rows.clone()]);
        y.iter_mut().zip(&self.changes).for_each(|(y, change)| *y += change);
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
        self.past_y.iter_mut().for_each(|past| past.fill(0.0));
        self.w.fill(0.0);
        (self.is_at_home, self.next) = (true, None);
    }

    fn measure(&mut self, row: usize, u: &[f64], f: &[f64], y: &mut [f64]) {
        self.look(row, u, f);
        self.outputs(row, y);
    }

    fn step(&mut self, row: usize, u: &[f64], f: &[f64], y: &mut [f64]) {
        self.measure(row, u, f, y);
        self.w.rotate_right(u.len() + f.len());
        for (past, change) in self.past_y.iter_mut().zip(&self.changes) {
            past.rotate_right(1);
            if let Some(newest) = past.first_mut() {
                *newest = *change;
            }
        }
        self.next = Some(row + 1);
    }

    fn state(&self) -> &[f64] {
        &self.x0
    }

    fn go_on_from(&mut self, _x: &[f64]) -> bool {
        false
    }
}
