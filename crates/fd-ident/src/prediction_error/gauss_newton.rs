//! Damped Gauss-Newton search (Levenberg-Marquardt) for small nonlinear least-squares problems.

use super::bordered::{Bordered, Compressed};
use crate::error::IdentError;

/// A sum of squares that depends on parameters.
pub(super) trait SumOfSquares {
    /// The sum at `p`; NaN or infinite where it is not defined.
    fn cost(&self, p: &[f64]) -> f64;

    /// Errors and their Jacobian at `p`.
    fn linearise(&self, p: &[f64]) -> Bordered;

    /// Brings parameters back to where the problem is defined.
    fn admit(&self, p: Vec<f64>) -> Result<Vec<f64>, IdentError>;
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Patience {
    /// Most linearisations.
    pub rounds: usize,
    /// Least promised decrease of the cost, relative to it, that is worth another round.
    pub tolerance: f64,
    /// Cost that is nothing but rounding.
    pub floor: f64,
}

/// Where a search ended.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    pub parameters: Vec<f64>,
    pub cost: f64,
    pub rounds: usize,
    pub converged: bool,
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
        let local = Compressed::new(problem.linearise(&best.parameters));
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
