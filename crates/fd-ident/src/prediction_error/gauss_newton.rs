//! Damped Gauss-Newton search (Levenberg-Marquardt) for small nonlinear least-squares problems.

use faer::{Mat, MatRef, prelude::SolveLstsq};

use crate::error::IdentError;

/// A sum of squares that depends on parameters.
pub(super) trait SumOfSquares {
    /// The sum at `p`; NaN or infinite where it is not defined.
    fn cost(&self, p: &[f64]) -> f64;

    /// Errors and their Jacobian at `p`.
    fn linearise(&self, p: &[f64]) -> (Mat<f64>, Mat<f64>);

    /// Brings parameters back to where the problem is defined.
    fn admit(&self, p: Vec<f64>) -> Result<Vec<f64>, IdentError>;
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Patience {
    /// Most linearisations.
    pub(super) rounds: usize,
    /// Least promised decrease of the cost, relative to it, that is worth another round.
    pub(super) tolerance: f64,
    /// Cost that is nothing but rounding.
    pub(super) floor: f64,
}

/// Where a search ended.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    pub(super) parameters: Vec<f64>,
    pub(super) cost: f64,
    pub(super) rounds: usize,
    pub(super) converged: bool,
}

/// Damping that a search begins with, and its largest value; both in units of the squared column
/// lengths (Marquardt's scaling).
const FIRST_DAMPING: f64 = 1e-3;
const LARGEST_DAMPING: f64 = 1e10;

/// Ljung (1999), eq. (10.46) with Marquardt's scaling: each round solves
/// `min ‖ε + J s‖² + λ ‖diag(J) s‖²` by QR, and λ grows until the cost falls.
pub(super) fn minimise(
    problem: &impl SumOfSquares,
    start: Vec<f64>,
    patience: Patience,
) -> Result<Minimum, IdentError> {
    let parameters = problem.admit(start)?;
    let cost = problem.cost(&parameters);
    let mut best = Minimum { parameters, cost, rounds: 0, converged: false };
    let mut damping = FIRST_DAMPING;
    while best.rounds < patience.rounds && best.cost.is_finite() {
        if best.cost <= patience.floor {
            best.converged = true;
            break;
        }
        best.rounds += 1;
        let local = Linearised::new(problem.linearise(&best.parameters));
        if local.promise(best.cost) <= patience.tolerance {
            best.converged = true;
            break;
        }
        let mut found = false;
        while !found && damping <= LARGEST_DAMPING {
            let step = local.step(damping);
            let trial = best.parameters.iter().zip(&step).map(|(p, s)| p + s).collect();
            let trial = problem.admit(trial)?;
            let cost = problem.cost(&trial);
            // A NaN fails the comparison.
            found = cost < best.cost;
            if found {
                (best.parameters, best.cost) = (trial, cost);
                damping = (damping / 10.0).max(1e-15);
            } else {
                damping *= 10.0;
            }
        }
        if !found {
            // No direction goes down any more: the minimum, to rounding, or the edge of what is
            // admitted. Only the first counts as converged.
            best.converged = local.promise(best.cost) <= patience.tolerance.sqrt();
            break;
        }
    }
    Ok(best)
}

/// The linear problem of one round, compressed by QR.
struct Linearised {
    /// Scaled triangular factor.
    r: Mat<f64>,
    /// `Qᵀ ε`.
    errors: Mat<f64>,
    /// Column lengths of the Jacobian, 1 for empty columns.
    lengths: Vec<f64>,
}

impl Linearised {
    fn new((jacobian, errors): (Mat<f64>, Mat<f64>)) -> Self {
        let n = jacobian.ncols();
        let length = |j: usize| {
            let length = jacobian.col(j).norm_l2();
            if length > 0.0 { length } else { 1.0 }
        };
        let lengths: Vec<f64> = (0..n).map(length).collect();
        let scaled = Mat::from_fn(jacobian.nrows(), n, |i, j| jacobian[(i, j)] / lengths[j]);
        let qr = scaled.qr();
        let r = qr.thin_R().to_owned();
        let errors = qr.compute_thin_Q().transpose() * errors;
        Self { r, errors, lengths }
    }

    /// Share of the cost that an undamped step promises to remove.
    fn promise(&self, cost: f64) -> f64 {
        self.errors.squared_norm_l2() / cost
    }

    fn step(&self, damping: f64) -> Vec<f64> {
        let (rows, n) = (self.r.nrows(), self.r.ncols());
        let stacked = Mat::from_fn(rows + n, n, |i, j| match i.checked_sub(rows) {
            None => self.r[(i, j)],
            Some(i) if i == j => damping.sqrt(),
            Some(_) => 0.0,
        });
        let target =
            Mat::from_fn(rows + n, 1, |i, _| if i < rows { -self.errors[(i, 0)] } else { 0.0 });
        let step = solve(stacked.as_ref(), target.as_ref());
        (0..n).map(|j| step[(j, 0)] / self.lengths[j]).collect()
    }
}

fn solve(x: MatRef<'_, f64>, y: MatRef<'_, f64>) -> Mat<f64> {
    x.qr().solve_lstsq(y)
}
