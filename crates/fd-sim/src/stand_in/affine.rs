//! A simulator linearised in each step of its replays.

use std::sync::Arc;

use super::{replayed::Linear, slopes::Slopes};

/// The simulator, linear around each step of the replays.
#[derive(Clone, Debug)]
pub(super) struct Affine {
    slopes: Arc<Slopes>,
    x: Vec<f64>,
    /// By how much the parameters are moved.
    theta: Vec<f64>,
    /// Changes of states, inputs, forces and parameters.
    moved: Vec<f64>,
    result: Vec<f64>,
}

impl Affine {
    pub(super) fn new(slopes: Slopes) -> Self {
        let [nx, .., parameters] = slopes.widths;
        let (moved, result) = (vec![0.0; slopes.widths.iter().sum()], vec![0.0; slopes.results()]);
        Self {
            slopes: Arc::new(slopes),
            x: vec![0.0; nx],
            theta: vec![0.0; parameters],
            moved,
            result,
        }
    }

    /// Outputs and next states of a step.
    fn results(&mut self, row: usize, u: &[f64], f: &[f64]) {
        let slopes = &*self.slopes;
        let [nx, nu, nf, _] = slopes.widths;
        let (x, rest) = self.moved.split_at_mut(nx);
        let (du, rest) = rest.split_at_mut(nu);
        let (df, theta) = rest.split_at_mut(nf);
        let known = &slopes.x[row * nx..(row + 1) * nx];
        x.iter_mut().zip(self.x.iter().zip(known)).for_each(|(dx, (x, known))| *dx = x - known);
        let known = &slopes.u[row * nu..(row + 1) * nu];
        du.iter_mut().zip(u.iter().zip(known)).for_each(|(du, (u, known))| *du = u - known);
        let known = &slopes.f[row * nf..(row + 1) * nf];
        df.iter_mut().zip(f.iter().zip(known)).for_each(|(df, (f, known))| *df = f - known);
        theta.copy_from_slice(&self.theta);
        let results = slopes.results();
        self.result.copy_from_slice(&slopes.result[row * results..(row + 1) * results]);
        for (moved, slope) in self.moved.iter().zip(slopes.of_row(row).chunks_exact(results)) {
            if *moved != 0.0 {
                self.result.iter_mut().zip(slope).for_each(|(to, slope)| *to += moved * slope);
            }
        }
    }
}

impl Linear for Affine {
    fn rows(&self) -> usize {
        self.slopes.rows()
    }

    fn start(&mut self, theta: &[f64], x0: &[f64]) {
        let nominal = &self.slopes.theta;
        self.theta.iter_mut().zip(theta.iter().zip(nominal)).for_each(|(d, (p, p0))| *d = p - p0);
        self.x.copy_from_slice(x0);
    }

    fn measure(&mut self, row: usize, u: &[f64], f: &[f64], y: &mut [f64]) {
        self.results(row, u, f);
        y.copy_from_slice(&self.result[..y.len()]);
    }

    fn step(&mut self, row: usize, u: &[f64], f: &[f64], y: &mut [f64]) {
        self.measure(row, u, f, y);
        self.x.copy_from_slice(&self.result[y.len()..]);
    }

    fn state(&self) -> &[f64] {
        &self.x
    }

    fn go_on_from(&mut self, x: &[f64]) -> bool {
        self.x.copy_from_slice(x);
        true
    }
}
