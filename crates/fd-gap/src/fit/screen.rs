//! How much a change of the outputs could explain, whatever the nuisances.

use fd_numeric::wide::{dot, dots};

use super::{
    arrow::Factor,
    layout::{Layout, LeastSquares},
    levenberg::Minimum,
};

/// Part of a change that must be left once the nuisances have taken theirs; less is rounding.
const INVISIBLE: f64 = 1e-9;

/// What a score test says of a change of the outputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// How many times the change the residual asks for.
    pub amplitude: f64,
    /// By how much the sum of squares would fall.
    pub gain: f64,
}

/// The space that the nuisances span around a minimum.
#[derive(Clone, Debug)]
pub struct Projection<'a> {
    layout: Layout,
    minimum: &'a Minimum,
    factor: Factor,
    /// `L⁻¹ g`.
    gradient: Vec<f64>,
}

impl<'a> Projection<'a> {
    /// The space around a minimum of a problem; `None` when its equations are singular.
    ///
    /// Nuisances at an edge of their box count as free: they may come back.
    #[must_use]
    pub fn new(problem: &dyn LeastSquares, minimum: &'a Minimum) -> Option<Self> {
        let layout = problem.layout().clone();
        let mut equations = minimum.equations(problem, 1.0);
        for i in 0..minimum.z.len() {
            if *equations.diagonal_mut(i) <= 0.0 {
                equations.fix(i);
            }
        }
        let factor = equations.factor()?;
        let mut gradient = equations.gradient;
        factor.forward(&mut gradient);
        Some(Self { layout, minimum, factor, gradient })
    }

    /// Score of the change from the residuals of the minimum to `changed`: with `d` the change and
    /// everything in the complement of the nuisances, `a = −⟨d, r⟩/⟨d, d⟩` within `range`, and the
    /// sum of squares falls by `−2a⟨d, r⟩ − a²⟨d, d⟩`.
    #[must_use]
    pub fn score(&self, changed: &[f64], range: [f64; 2]) -> Score {
        let r = &self.minimum.r;
        let change: Vec<f64> = changed.iter().zip(r).map(|(c, r)| c - r).collect();
        let mut seen = vec![0.0; self.layout.unknowns()];
        for (s, rows) in self.layout.segments.iter().enumerate() {
            let slopes = self.minimum.slopes.iter().map(|slope| &slope[rows.clone()]);
            let slopes: Vec<&[f64]> = slopes.collect();
            for (i, product) in dots(&change[rows.clone()], &slopes).into_iter().enumerate() {
                let shared = self.layout.shared;
                let place = if i < shared { i } else { self.layout.first_own(s) + i - shared };
                seen[place] += product;
            }
        }
        self.factor.forward(&mut seen);
        let all = dot(&change, &change);
        let left = all - dot(&seen, &seen);
        if left <= INVISIBLE * all {
            return Score { amplitude: 0.0, gain: 0.0 };
        }
        let along = dot(&change, r) - dot(&seen, &self.gradient);
        let amplitude = (-along / left).clamp(range[0], range[1]);
        let gain = -2.0 * amplitude * along - amplitude * amplitude * left;
        Score { amplitude, gain: gain.max(0.0) }
    }
}
