//! Levenberg's and Marquardt's method in a box.

use super::{
    arrow::Arrow,
    layout::{Layout, LeastSquares},
};

/// How long to search, and what to leave as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Most Jacobians.
    pub iterations: usize,
    /// Ends when the sum of squares falls by less than this …
    pub absolute: f64,
    /// … plus this fraction of it.
    pub relative: f64,
    /// The slopes of the first so many shared unknowns, and those of the own ones, are not
    /// computed again, once they are known.
    pub frozen: usize,
    /// The shared unknowns stay where they are.
    pub own_only: bool,
}

impl Default for Search {
    fn default() -> Self {
        Self { iterations: 30, absolute: 1e-3, relative: 1e-7, frozen: 0, own_only: false }
    }
}

/// Damping at the beginning, as a fraction of the diagonal of the normal equations.
const DAMPING: f64 = 1e-3;
/// Damping at which a search gives up.
const HIGHEST_DAMPING: f64 = 1e8;
/// Part of the way to the edge of the box that counts as being there.
const EDGE: f64 = 1e-9;

/// A place in the space of the unknowns, with what is known there.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// Scaled unknowns.
    pub z: Vec<f64>,
    /// Sum of squares of the residuals, and of the prior.
    pub cost: f64,
    /// The part of the prior.
    pub prior_cost: f64,
    /// Residuals.
    pub r: Vec<f64>,
    /// Slopes, column by column, at the last place at which they were computed.
    pub slopes: Vec<Vec<f64>>,
    /// Whether the search ended because it could not get lower.
    pub converged: bool,
}

fn cost(problem: &dyn LeastSquares, z: &[f64], r: &[f64]) -> [f64; 2] {
    let prior = problem.prior().iter().zip(z).map(|([m, p], z)| p * (z - m).powi(2)).sum::<f64>();
    [r.iter().map(|r| r * r).sum::<f64>() + prior, prior]
}

/// Minimises a sum of squares within its box, from `z` on. Where residuals are not finite the
/// cost is infinite, so that the step shrinks. Returns `None` when it is so at the start.
///
/// An unknown at the edge of its box that wants to get out stays there for the step; other steps
/// end at the edge (projected Levenberg-Marquardt; Nocedal & Wright 2006, sections 10.3, 16.7).
///
/// `slopes` of a nearby place may be given, for [`Search::frozen`].
///
/// # Panics
///
/// Panics when `z` does not have one value per unknown.
#[must_use]
pub fn minimise(
    problem: &mut dyn LeastSquares,
    z: &[f64],
    slopes: Option<&[Vec<f64>]>,
    search: Search,
) -> Option<Minimum> {
    let layout: Layout = problem.layout().clone();
    assert_eq!(z.len(), layout.unknowns(), "one start per unknown");
    let bounds = problem.bounds().to_vec();
    let z: Vec<f64> = z.iter().zip(&bounds).map(|(z, [low, high])| z.clamp(*low, *high)).collect();
    let mut r = vec![0.0; layout.residuals()];
    if !problem.residuals(&z, &mut r) {
        return None;
    }
    let [total, prior_cost] = cost(problem, &z, &r);
    let columns = layout.shared + layout.own;
    let mut known = slopes.is_some();
    let slopes = slopes.map_or_else(|| vec![vec![0.0; r.len()]; columns], <[Vec<f64>]>::to_vec);
    let mut at = Minimum { z, cost: total, prior_cost, r, slopes, converged: false };
    let mut trial = at.r.clone();
    let mut damping = DAMPING;

    for _ in 0..search.iterations {
        let refresh = if search.own_only {
            layout.shared..columns
        } else if known && 0 < search.frozen {
            search.frozen..layout.shared
        } else {
            0..columns
        };
        problem.slopes(&at.z, &at.r, refresh, &mut at.slopes);
        known = true;
        let mut equations = Arrow::new(&layout, &at.slopes, &at.r, problem.prior(), &at.z, 1.0);
        for (i, [low, high]) in bounds.iter().enumerate() {
            let (edge, slope) = (EDGE * (high - low), equations.gradient[i]);
            let is_held = search.own_only && i < layout.shared
                || at.z[i] <= low + edge && 0.0 <= slope
                || high - edge <= at.z[i] && slope <= 0.0;
            if is_held || *equations.diagonal_mut(i) <= 0.0 {
                equations.fix(i);
            }
        }
        let before = at.cost;
        while damping < HIGHEST_DAMPING {
            let mut damped = equations.clone();
            for i in 0..at.z.len() {
                *damped.diagonal_mut(i) *= 1.0 + damping;
            }
            let Some(factor) = damped.factor() else {
                damping *= 10.0;
                continue;
            };
            let mut step = equations.gradient.clone();
            factor.solve(&mut step);
            let moved = at.z.iter().zip(&step).zip(&bounds);
            let next: Vec<f64> =
                moved.map(|((z, step), [low, high])| (z - step).clamp(*low, *high)).collect();
            let predicted: f64 = step.iter().zip(&equations.gradient).map(|(a, b)| a * b).sum();
            if problem.residuals(&next, &mut trial) {
                let [total, prior_cost] = cost(problem, &next, &trial);
                if total < at.cost {
                    (at.z, at.cost, at.prior_cost) = (next, total, prior_cost);
                    std::mem::swap(&mut at.r, &mut trial);
                    damping = (damping / 10.0).max(1e-9);
                    break;
                }
            }
            if predicted < search.absolute + search.relative * at.cost {
                break;
            }
            damping *= 10.0;
        }
        if before - at.cost <= search.absolute + search.relative * at.cost {
            at.converged = damping < HIGHEST_DAMPING;
            break;
        }
    }
    Some(at)
}
