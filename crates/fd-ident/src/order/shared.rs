//! The fits of all candidates from one factorisation that grows column by column.
//!
//! The regressors of a candidate are columns of the widest one: past values of the bias, a run of
//! inputs, a constant. Candidates that start with the same columns share the Householder
//! reflections of these columns, so a tree of them — constant, then one past value after the
//! other, then for each delay one input after the other — fits every candidate with one
//! reflection and one back-substitution each.

use std::collections::{HashMap, HashSet};

use faer::MatRef;

use crate::arx::ArxOrders;

/// The parameters of every candidate whose columns are certainly independent.
pub(super) type Fits = HashMap<ArxOrders, Vec<f64>>;

/// Where the columns of the widest regressor are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Columns {
    /// Past values of the bias in the widest regressor; the inputs follow, from delay 0 on.
    pub na: usize,
    pub nu: usize,
    /// Column of the constant.
    pub constant: usize,
}

/// A triangular factor and what is left of the other columns.
#[derive(Clone)]
struct Tree {
    /// All columns, reflected; the target is the last one.
    columns: Vec<Vec<f64>>,
    /// Columns that are triangular already, in their order.
    chosen: Vec<usize>,
}

/// Fits all candidates to one residual channel, given the triangular factor `[Φ y]` of its data.
/// A candidate without a fit may be rank deficient and has to be looked at on its own.
pub(super) fn fit_all(r: MatRef<'_, f64>, at: Columns, candidates: &HashSet<ArxOrders>) -> Fits {
    let columns: Vec<Vec<f64>> =
        (0..r.ncols()).map(|j| (0..r.nrows()).map(|i| r[(i, j)]).collect()).collect();
    let root = Tree { columns, chosen: Vec::new() };
    let mut fits = Fits::new();
    for offset in [false, true] {
        let wanted: Vec<ArxOrders> =
            candidates.iter().copied().filter(|orders| orders.offset == offset).collect();
        let most = |of: &dyn Fn(&ArxOrders) -> usize| wanted.iter().map(of).max();
        let Some(most_past) = most(&|orders| orders.na) else { continue };
        let mut past = root.clone();
        if offset {
            past.append(at.constant);
        }
        for na in 0..=most_past {
            if na > 0 {
                past.append(na - 1);
            }
            let here: Vec<&ArxOrders> = wanted.iter().filter(|orders| orders.na == na).collect();
            for orders in here.iter().filter(|orders| orders.nb == 0) {
                past.fit(**orders, at, &mut fits);
            }
            let delays: HashSet<usize> = here.iter().map(|orders| orders.delay).collect();
            for delay in delays {
                let taps = here.iter().filter(|orders| orders.delay == delay);
                let most_taps = taps.map(|orders| orders.nb).max().unwrap_or(0);
                let mut inputs = past.clone();
                for tap in 0..most_taps {
                    let first = at.na + (delay + tap) * at.nu;
                    (first..first + at.nu).for_each(|column| inputs.append(column));
                    let orders = ArxOrders { na, nb: tap + 1, delay, offset };
                    if candidates.contains(&orders) {
                        inputs.fit(orders, at, &mut fits);
                    }
                }
            }
        }
    }
    fits
}

impl Tree {
    /// Makes one more column triangular, by a Householder reflection of all columns.
    fn append(&mut self, column: usize) {
        let k = self.chosen.len();
        self.chosen.push(column);
        let mut v = self.columns[column][k..].to_vec();
        let length = v.iter().map(|v| v * v).sum::<f64>().sqrt();
        if length <= 0.0 {
            return;
        }
        v[0] += length.copysign(v[0]);
        let square: f64 = v.iter().map(|v| v * v).sum();
        for column in &mut self.columns {
            let rest = &mut column[k..];
            let along: f64 = rest.iter().zip(&v).map(|(x, v)| x * v).sum();
            let factor = 2.0 * along / square;
            rest.iter_mut().zip(&v).for_each(|(x, v)| *x -= factor * v);
        }
    }

    /// Entry of the triangular factor.
    fn r(&self, i: usize, j: usize) -> f64 {
        self.columns[self.chosen[j]][i]
    }

    /// Solves for the chosen columns, if they are independent beyond doubt.
    fn fit(&self, orders: ArxOrders, at: Columns, fits: &mut Fits) {
        if !self.is_independent() {
            return;
        }
        let n = self.chosen.len();
        let target = &self.columns[self.columns.len() - 1];
        let mut x = target[..n].to_vec();
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|j| self.r(i, j) * x[j]).sum();
            x[i] = (x[i] - known) / self.r(i, i);
        }
        // The constant came first, and is the last parameter.
        if orders.offset {
            x.rotate_left(1);
        }
        debug_assert_eq!(x.len(), orders.parameters(at.nu));
        fits.insert(orders, x);
    }

    /// Whether `‖R‖ ‖R⁻¹‖`, with columns of length one, is far below what rounding would hide.
    ///
    /// In Frobenius norms this is never below the condition number, and at most `n` times it.
    fn is_independent(&self) -> bool {
        let n = self.chosen.len();
        let length = |j: usize| (0..=j).map(|i| self.r(i, j).powi(2)).sum::<f64>().sqrt();
        let lengths: Vec<f64> = (0..n).map(length).collect();
        if n == 0 || (0..n).any(|j| self.r(j, j).abs() <= 0.0) {
            return false;
        }
        let mut inverse_square = 0.0;
        let mut column = vec![0.0; n];
        for j in 0..n {
            column[j] = lengths[j] / self.r(j, j);
            for i in (0..j).rev() {
                let sum: f64 = (i + 1..=j).map(|k| self.r(i, k) / lengths[k] * column[k]).sum();
                column[i] = -sum * lengths[i] / self.r(i, i);
            }
            inverse_square += column[..=j].iter().map(|x| x * x).sum::<f64>();
        }
        let condition = (n as f64 * inverse_square).sqrt();
        condition < SURELY_INDEPENDENT
    }
}

/// Largest condition that needs no second look: the rank decision of least squares, at `10 n ε`
/// for at most some hundred columns, lies far above.
const SURELY_INDEPENDENT: f64 = 1e9;
