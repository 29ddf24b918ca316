//! How outputs change with inputs and forces, as difference equations.

use std::sync::Arc;

/// `y(k) = Σ a_i y(k−i) + Σ_j Σ b_ji w_j(k−i)` of the changes of an output `y` and of all inputs and forces `w`, from rest.
///
/// ```
/// use std::sync::Arc;
///
/// use fd_sim::simulate::{Changes, DifferenceEquation};
///
/// // A lag by one sample that keeps half of what it was.
/// let lag = DifferenceEquation::new(vec![0.5], vec![vec![0.0, 0.5]]);
/// let mut changes = Changes::new(Arc::new([lag]));
/// let steps = [1.0, 1.0, 1.0].map(|w| {
///     let y = changes.of(&[w])[0];
///     changes.move_on();
///     y
/// });
/// assert_eq!(steps, [0.0, 0.5, 0.75]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DifferenceEquation {
    pub(crate) a: Vec<f64>,
    /// Per input and force, from `i = 0` on.
    pub(crate) b: Vec<Vec<f64>>,
}

impl DifferenceEquation {
    /// The equation with `a_1, a_2, …`, and for each input and force `b_0, b_1, …`.
    #[must_use]
    pub fn new(a: Vec<f64>, b: Vec<Vec<f64>>) -> Self {
        Self { a, b }
    }

    /// The next change, from those before, the newest first; `w` begins with what drives it now.
    pub(crate) fn next(&self, past_y: &[f64], w: &[f64]) -> f64 {
        let own: f64 = self.a.iter().zip(past_y).map(|(a, y)| a * y).sum();
        let driven = |(j, b): (usize, &Vec<f64>)| -> f64 {
            b.iter().zip(w[j..].iter().step_by(self.b.len())).map(|(b, w)| b * w).sum()
        };
        own + self.b.iter().enumerate().map(driven).sum::<f64>()
    }

    fn order(&self) -> usize {
        self.b.iter().map(|b| b.len().saturating_sub(1)).max().unwrap_or(0).max(self.a.len())
    }
}

/// The changes of all outputs in the course of a run.
#[derive(Clone, Debug)]
pub struct Changes {
    /// One per output, all with as many inputs and forces.
    equations: Arc<[DifferenceEquation]>,
    /// The last changes of each output, the newest first.
    past_y: Vec<Vec<f64>>,
    /// The changes of all inputs and forces now, and before, the newest first.
    w: Vec<f64>,
    y: Vec<f64>,
}

impl Changes {
    /// Changes from rest, with the equation of each output.
    #[must_use]
    pub fn new(equations: Arc<[DifferenceEquation]>) -> Self {
        let order = equations.iter().map(DifferenceEquation::order).max().unwrap_or(0);
        let driven = equations.first().map_or(0, |equation| equation.b.len());
        Self {
            past_y: vec![vec![0.0; order]; equations.len()],
            w: vec![0.0; driven * (order + 1)],
            y: vec![0.0; equations.len()],
            equations,
        }
    }

    /// Begins again at rest.
    pub fn rest(&mut self) {
        self.past_y.iter_mut().for_each(|past| past.fill(0.0));
        self.w.fill(0.0);
    }

    /// The changes of the outputs where inputs and forces change by `w` now.
    pub fn of(&mut self, w: &[f64]) -> &[f64] {
        self.w[..w.len()].copy_from_slice(w);
        let equations = self.equations.iter().zip(&self.past_y);
        self.y.iter_mut().zip(equations).for_each(|(y, (e, past))| *y = e.next(past, &self.w));
        &self.y
    }

    /// Moves on by a sample from the changes that were looked at last.
    pub fn move_on(&mut self) {
        self.w.rotate_right(self.equations.first().map_or(0, |equation| equation.b.len()));
        for (past, y) in self.past_y.iter_mut().zip(&self.y) {
            past.rotate_right(1);
            if let Some(newest) = past.first_mut() {
                *newest = *y;
            }
        }
    }
}
