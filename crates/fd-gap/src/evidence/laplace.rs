//! Evidence of a fitted model by Laplace's method.

use std::f64::consts::PI;

use super::likelihood::Likelihood;
use crate::fit::{LeastSquares, Minimum, Problem};

/// `ln 10⁶`: a strength is anything within six decades, each as likely as the other.
pub const DECADES: f64 = 13.8;

/// `ln ∫ likelihood × prior`, up to a constant that all models of the same data, nuisances and
/// initial states share:
/// `LL − ½ Σ((θ − θ₀)/s)² − ½ ln det H + Σ (½ ln 2π + ln p(φ))`.
///
/// Strengths have a log-uniform prior, `p = 1/(13.8 √(2π) max(|φ|, σ_φ))` with one common size
/// `|φ|` (in scales) for several strengths of one effect; shapes are uniform in their box.
/// `effects` holds, effect by effect, for each parameter the neutral value if it is a strength.
///
/// `None` when the equations are singular.
#[must_use]
pub fn evidence(
    problem: &Problem,
    at: &Minimum,
    likelihood: &Likelihood,
    effects: &[&[Option<f64>]],
) -> Option<f64> {
    let scales = &likelihood.scale;
    let scale = f64::sqrt(scales.iter().map(|s| s * s).sum::<f64>() / scales.len() as f64);
    let weight = 1.0 / scale;
    let layout = problem.layout();
    let mut equations = at.equations(problem, weight);
    let first = layout.shared - problem.effects().len();
    for i in 0..at.z.len() {
        let [low, high] = problem.bounds()[i];
        if i < first || layout.shared <= i {
            // An exact state of a first window takes no part.
            if high <= low {
                equations.fix(i);
            }
        } else if (high - low).is_finite() {
            // What the data do not tell, the box does: the variance of a uniform distribution.
            *equations.diagonal_mut(i) += 12.0 / (high - low).powi(2);
        }
    }
    let factor = equations.factor()?;
    let (mut log_prior, mut place) = (0.0, first);
    for strengths in effects {
        let (mut squares, mut count) = (0.0, 0.0_f64);
        for (i, strength) in strengths.iter().enumerate() {
            if let Some(neutral) = strength {
                let variable = &problem.effects()[place - first + i];
                squares += (at.z[place + i] - variable.scaled(*neutral)).powi(2);
                count += 1.0;
            }
        }
        let size = f64::sqrt(squares / count.max(1.0));
        log_prior -= if 0.0 < count { DECADES.ln() } else { 0.0 };
        for (i, strength) in strengths.iter().enumerate() {
            let [low, high] = problem.bounds()[place + i];
            log_prior += if strength.is_some() {
                -size.max(factor.variance(place + i).sqrt()).ln()
            } else {
                0.5 * (2.0 * PI).ln() - (high - low).ln()
            };
        }
        place += strengths.len();
    }
    Some(likelihood.log - 0.5 * at.prior_cost - 0.5 * factor.log_determinant() + log_prior)
}
