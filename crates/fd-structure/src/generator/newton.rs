//! Blocks of equations, solved.

use fd_sim::equation::{Program, Workspace};
use nalgebra::{DMatrix, DVector};

/// Iterations before a block is given up.
const MOST_ITERATIONS: usize = 50;
/// How often a step is halved before a block is given up.
const MOST_HALVINGS: usize = 20;
/// A step of Newton's method that is smaller than this, relative to the unknown, is the last one: its error is of the
/// order of the square.
const LAST_STEP: f64 = 1e-9;
/// A step that has stopped shrinking is rounding if it is smaller than this.
const ROUNDING: f64 = 1e-6;

/// The formula of an unknown; or the differences of some equations, then their slopes, row by row.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub program: Program,
    /// Places of the unknowns among the fast inputs.
    pub places: Vec<usize>,
    pub is_formula: bool,
}

impl Block {
    /// Writes the solution into `fast`, starting from what is there. False if there is none that is finite.
    pub(super) fn solve(&self, workspace: &mut Workspace<f64>, fast: &mut [f64]) -> bool {
        if !self.is_formula {
            return self.iterate(workspace, fast);
        }
        let mut value = [f64::NAN];
        workspace.fast_mut().copy_from_slice(fast);
        self.program.run(workspace, &mut value);
        self.places.iter().for_each(|&place| fast[place] = value[0]);
        value[0].is_finite()
    }

    fn iterate(&self, workspace: &mut Workspace<f64>, fast: &mut [f64]) -> bool {
        let n = self.places.len();
        let mut values = vec![0.0; n + n * n];
        let mut evaluate = |fast: &[f64]| {
            workspace.fast_mut().copy_from_slice(fast);
            self.program.run(workspace, &mut values);
            let differences = DVector::from_column_slice(&values[..n]);
            (differences, DMatrix::from_row_slice(n, n, &values[n..]))
        };
        let (mut differences, mut slopes) = evaluate(fast);
        let mut before = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            let Some(step) = slopes.clone().lu().solve(&differences) else { return false };
            let start: Vec<f64> = self.places.iter().map(|&place| fast[place]).collect();
            // The size of the step, relative to the unknowns.
            let size = step
                .iter()
                .zip(&start)
                .map(|(step, value)| step.abs() / (value.abs() + f64::MIN_POSITIVE.sqrt()))
                .fold(0.0, f64::max);
            let mut share = 1.0;
            let old = differences.norm();
            for halving in 0.. {
                for (index, &place) in self.places.iter().enumerate() {
                    fast[place] = start[index] - share * step[index];
                }
                (differences, slopes) = evaluate(fast);
                let is_usable =
                    differences.norm().is_finite() && slopes.iter().all(|s| s.is_finite());
                let is_better = differences.norm() <= old || size < ROUNDING;
                if is_usable && is_better {
                    break;
                }
                if halving == MOST_HALVINGS {
                    return false;
                }
                share *= 0.5;
            }
            let is_exact = differences.iter().all(|difference| *difference == 0.0);
            if is_exact || size < LAST_STEP || (size < ROUNDING && before * 0.5 < size) {
                return true;
            }
            before = size;
        }
        false
    }
}
