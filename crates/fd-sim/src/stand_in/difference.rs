//! Difference equations of the responses to inputs and forces.
//!
//! `y(k) = Σ a_i y(k−i) + Σ_j Σ b_ji w_j(k−i)` by least squares on runs in which one `w_j` was moved each (Ljung 1999,
//! section 4.2). There is no noise in these, so that an equation of the right order is exact but for the curvature
//! of the plant; the order is the least one whose *simulation* is nearly as good as any other's.

use faer::{Mat, linalg::solvers::SolveLstsq};
use fd_numeric::dense::Dense;

use crate::simulate::DifferenceEquation;

/// Steps into one direction, one after another: fast and slow plants are moved.
const HOLDS: [usize; 6] = [3, 29, 7, 83, 13, 47];
/// Orders that are tried.
const ORDERS: [usize; 6] = [1, 2, 3, 4, 6, 8];
/// Weight against coefficients that nothing determines, as a part of the data.
const RIDGE: f64 = 1e-9;
/// A higher order must leave less than this part of what a lower one does.
const BETTER: f64 = 0.9;

/// How the outputs change when one input or force is moved up and down by `size`.
pub(super) struct Response {
    pub size: f64,
    /// Changes, row by row.
    pub change: Vec<f64>,
}

/// The responses to all inputs and forces.
pub(super) struct Data<'a> {
    pub responses: &'a [Response],
    /// First rows of the replays.
    pub begins: &'a [usize],
    pub ny: usize,
}

impl Data<'_> {
    /// The equation of each output.
    pub(super) fn equations(&self) -> Vec<DifferenceEquation> {
        (0..self.ny).map(|output| self.equation(output)).collect()
    }

    /// The replays, each as a range of rows.
    fn replays(&self) -> impl Iterator<Item = std::ops::Range<usize>> {
        let rows = self.responses.first().map_or(0, |r| r.change.len() / self.ny);
        let ends = self.begins.iter().skip(1).copied().chain([rows]);
        self.begins.iter().copied().zip(ends).map(|(begin, end)| begin..end)
    }

    /// Change of an output in a row before or at row `k` of a replay, which begins at rest.
    fn change(&self, response: &Response, output: usize, begin: usize, k: Option<usize>) -> f64 {
        k.map_or(0.0, |k| response.change[(begin + k) * self.ny + output])
    }

    fn equation(&self, output: usize) -> DifferenceEquation {
        let squares: f64 = self
            .responses
            .iter()
            .flat_map(|r| r.change.iter().skip(output).step_by(self.ny))
            .map(|y| y * y)
            .sum();
        let still =
            DifferenceEquation { a: vec![0.0], b: vec![vec![0.0; 2]; self.responses.len()] };
        if squares == 0.0 {
            return still;
        }
        let mut best = (still, squares);
        for order in ORDERS {
            let Some(equation) = self.of_order(output, order, squares) else { continue };
            let left = self.left(&equation, output);
            if left < BETTER * best.1 {
                best = (equation, left);
            }
        }
        best.0
    }

    /// The equation of an order, by least squares.
    fn of_order(&self, output: usize, order: usize, squares: f64) -> Option<DifferenceEquation> {
        let driven = self.responses.len();
        let columns = order + driven * (order + 1);
        let rows = driven * self.replays().map(|replay| replay.len()).sum::<usize>();
        let scale = (squares / rows as f64).sqrt();
        let mut left = Mat::zeros(rows + columns, columns);
        let mut right = Mat::zeros(rows + columns, 1);
        let mut row = 0;
        for (j, response) in self.responses.iter().enumerate() {
            for replay in self.replays() {
                for k in 0..replay.len() {
                    let past =
                        |i: usize| self.change(response, output, replay.start, k.checked_sub(i));
                    for i in 1..=order {
                        left[(row, i - 1)] = past(i) / scale;
                    }
                    for i in 0..=order {
                        let w = k.checked_sub(i).map_or(0.0, |k| pulse(1.0, k));
                        left[(row, order + j * (order + 1) + i)] = w;
                    }
                    right[(row, 0)] = past(0) / scale;
                    row += 1;
                }
            }
        }
        for column in 0..columns {
            left[(rows + column, column)] = RIDGE * (rows as f64).sqrt();
        }
        let found = left.factor_qr().solve_lstsq(right);
        let found: Vec<f64> = (0..columns).map(|i| found[(i, 0)]).collect();
        let b = found[order..].chunks_exact(order + 1).zip(self.responses);
        let b = b.map(|(b, r)| b.iter().map(|b| b * scale / r.size).collect()).collect();
        let equation = DifferenceEquation { a: found[..order].to_vec(), b };
        found.iter().all(|value| value.is_finite()).then_some(equation)
    }

    /// What a simulation of an equation leaves of the responses, as a sum of squares.
    fn left(&self, equation: &DifferenceEquation, output: usize) -> f64 {
        let (order, driven) = (equation.a.len(), self.responses.len());
        let mut squares = 0.0;
        for (j, response) in self.responses.iter().enumerate() {
            for replay in self.replays() {
                let (mut past, mut w) = (vec![0.0; order], vec![0.0; driven * (order + 1)]);
                for k in 0..replay.len() {
                    w[j] = pulse(response.size, k);
                    let y = equation.next(&past, &w);
                    squares += (y - self.change(response, output, replay.start, Some(k))).powi(2);
                    w.rotate_right(driven);
                    w[..driven].fill(0.0);
                    past.rotate_right(1);
                    past[0] = y;
                }
            }
        }
        if squares.is_finite() { squares } else { f64::INFINITY }
    }
}

/// What an input or a force is moved by in a step: up and down, for as many steps as `HOLDS` say.
pub(super) fn pulse(size: f64, k: usize) -> f64 {
    let mut left = k % (2 * HOLDS.iter().sum::<usize>());
    for (i, hold) in HOLDS.iter().cycle().enumerate() {
        if left < *hold {
            return if i % 2 == 0 { size } else { -size };
        }
        left -= hold;
    }
    0.0
}
