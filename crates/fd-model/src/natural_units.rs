//! Units of all signals in which a model has entries of like size.

use faer::{Mat, MatRef, prelude::Solve};
use fd_numeric::dense::Dense;

use crate::{domain::TimeDomain, error::ModelError, state_space::StateSpace};

/// States, inputs and outputs are measured in these units, and time in `1/rate`.
///
/// All numbers are powers of two, so that a change to these units is free of rounding.
///
/// # Examples
///
/// A lag whose state is in micrometres while its output is in metres:
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace};
///
/// let (a, b, c) = (mat![[-2.0]], mat![[2e6]], mat![[1e-6]]);
/// let lag = StateSpace::new(a, b, c, mat![[0.0]], Continuous)?;
/// let units = lag.natural_units();
/// let natural = lag.in_units(&units)?;
/// // Not farther than a factor of two from one.
/// assert!((0.5..=2.0).contains(&natural.b()[(0, 0)]) && (0.5..=2.0).contains(&natural.c()[(0, 0)]));
/// assert_eq!(units.rate, 2.0);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NaturalUnits {
    /// One unit of each state in natural units, in the units of the model.
    pub states: Vec<f64>,
    /// The same of each input.
    pub inputs: Vec<f64>,
    /// The same of each output.
    pub outputs: Vec<f64>,
    /// Size of `A`, 1/s, or per sample for discrete models: the Frobenius norm.
    pub rate: f64,
}

impl<D: TimeDomain> StateSpace<D> {
    /// Units in which all entries are as near to one as they can be, then each column of `[B; D]` and each
    /// row of `C` of unit size.
    ///
    /// Scaling by least squares of the logarithms (Curtis and Reid 1972) of all entries of the system
    /// matrix `[A B; C D]`, with the rate as one more unknown: other units to begin with shift the solution
    /// by just as much, and a coupling that goes one way only is held as firmly as one that goes both
    /// ways, which balancing by norms (Osborne 1960) lets fade to nothing. Repeated with entries weighed
    /// by their size in the units found, so that weak side paths have little say.
    ///
    /// Entries that are rounding next to the others of their row and column have no part in it. A signal
    /// that no entry ties to another keeps its unit.
    #[must_use]
    pub fn natural_units(&self) -> NaturalUnits {
        const REWEIGHTED: usize = 3;

        let clean = self.without_rounding();
        let entries = clean.entries();
        let mut weights = vec![1.0; entries.len()];
        let count = self.nx() + self.nu() + self.ny() + 1;
        let mut units = vec![0.0; count];
        for _ in 0..REWEIGHTED {
            units = least_squares(&entries, &weights, count);
            let sizes: Vec<f64> = entries.iter().map(|entry| entry.octaves(&units)).collect();
            let (mut rows, mut columns) =
                (vec![f64::NEG_INFINITY; count], vec![f64::NEG_INFINITY; count]);
            for (entry, size) in entries.iter().zip(&sizes) {
                rows[entry.row] = size.max(rows[entry.row]);
                columns[entry.column] = size.max(columns[entry.column]);
            }
            for ((weight, entry), size) in weights.iter_mut().zip(&entries).zip(&sizes) {
                *weight = (size - rows[entry.row].max(columns[entry.column])).exp2();
            }
        }
        clean.signal_units(
            units.iter().take(self.nx()).map(|unit| power_of_two(unit.exp2())).collect(),
        )
    }

    /// The entries of `[A B; C D]` that are not zero: states are signals `0..n`, then inputs, then outputs.
    fn entries(&self) -> Vec<Entry> {
        let (n, m) = (self.nx(), self.nu());
        let of = |matrix: MatRef<'_, f64>, row: usize, column: usize, timed: bool| {
            let all = (0..matrix.ncols()).flat_map(|j| (0..matrix.nrows()).map(move |i| (i, j)));
            let kept = all.filter(|&(i, j)| matrix[(i, j)] != 0.0);
            let entry = |(i, j)| {
                let size = matrix[(i, j)].abs().log2();
                Entry { row: row + i, column: column + j, size, timed }
            };
            kept.map(entry).collect::<Vec<_>>()
        };
        let parts = [
            of(self.a(), 0, 0, true),
            of(self.b(), 0, n, true),
            of(self.c(), n + m, 0, false),
            of(self.d(), n + m, n, false),
        ];
        parts.into_iter().flatten().collect()
    }

    /// The model with zeros for entries that are rounding next to the others of their row and column in
    /// `A`, of their column in `B` and of their row in `C`.
    fn without_rounding(&self) -> Self {
        const ROUNDING: f64 = 4.0 * f64::EPSILON;
        let norms = |m: MatRef<'_, f64>| -> [Vec<f64>; 2] {
            let rows = (0..m.nrows()).map(|i| m.row(i).norm_l2());
            let columns = (0..m.ncols()).map(|j| m.col(j).norm_l2());
            [rows.collect(), columns.collect()]
        };
        let [rows, columns] = norms(self.a());
        let [_, inputs] = norms(self.b());
        let [outputs, _] = norms(self.c());
        let above = |m: MatRef<'_, f64>, size: &dyn Fn(usize, usize) -> f64| {
            let kept = |i, j| if ROUNDING * size(i, j) < m[(i, j)].abs() { m[(i, j)] } else { 0.0 };
            Mat::from_fn(m.nrows(), m.ncols(), kept)
        };
        Self {
            a: above(self.a(), &|i, j| rows[i].min(columns[j])),
            b: above(self.b(), &|_, j| inputs[j]),
            c: above(self.c(), &|i, _| outputs[i]),
            d: self.d().to_owned(),
            domain: self.domain(),
        }
    }

    /// The units of inputs, outputs and time that belong to those of the states.
    fn signal_units(&self, states: Vec<f64>) -> NaturalUnits {
        let (a, b, c, d) = (self.a(), self.b(), self.c(), self.d());
        let n = self.nx();
        let scaled = Mat::from_fn(n, n, |i, j| a[(i, j)] * (states[j] / states[i]));
        let rate = power_of_two(scaled.norm_l2());
        let seen = |i: usize| norm((0..n).map(|j| c[(i, j)] * states[j]));
        let direct = |i: usize| norm((0..self.nu()).map(|j| d[(i, j)]));
        let outputs = (0..self.ny()).map(|i| {
            let seen = seen(i);
            power_of_two(if 0.0 < seen { seen } else { direct(i) })
        });
        let outputs: Vec<f64> = outputs.collect();
        let inputs = (0..self.nu()).map(|j| {
            let into_states = (0..n).map(|i| b[(i, j)] / states[i] / rate);
            let into_outputs = (0..self.ny()).map(|i| d[(i, j)] / outputs[i]);
            power_of_two(norm(into_states.chain(into_outputs)).recip())
        });
        NaturalUnits { inputs: inputs.collect(), outputs, rate, states }
    }

    /// The model with its signals in these units; time stays as it is.
    ///
    /// Units of other numbers of signals leave the surplus signals as they are.
    ///
    /// # Errors
    ///
    /// Returns an error when an entry grows out of range, which those of this model cannot cause.
    pub fn in_units(&self, units: &NaturalUnits) -> Result<Self, ModelError> {
        let of = |units: &[f64], i: usize| units.get(i).copied().unwrap_or(1.0);
        let change = |m: MatRef<'_, f64>, rows: &[f64], columns: &[f64]| {
            Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * (of(columns, j) / of(rows, i)))
        };
        let (x, u, y) = (&units.states, &units.inputs, &units.outputs);
        Self::new(
            change(self.a(), x, x),
            change(self.b(), x, u),
            change(self.c(), y, x),
            change(self.d(), y, u),
            self.domain(),
        )
    }
}

/// An entry of the system matrix, in octaves.
struct Entry {
    row: usize,
    column: usize,
    size: f64,
    /// In units of the rate.
    timed: bool,
}

impl Entry {
    /// Its size in these units, in octaves: of all signals, and the rate last.
    fn octaves(&self, units: &[f64]) -> f64 {
        let rate = if self.timed { units.last().copied().unwrap_or(0.0) } else { 0.0 };
        self.size + units[self.column] - units[self.row] - rate
    }
}

/// Units (in octaves) with the least weighted squares of the entries' octaves.
fn least_squares(entries: &[Entry], weights: &[f64], count: usize) -> Vec<f64> {
    /// Holds the common factor of signals that no entry ties to the others.
    const RIDGE: f64 = 1e-9;

    let mut normal = Mat::from_fn(count, count, |i, j| if i == j { RIDGE } else { 0.0 });
    let mut right = Mat::<f64>::zeros(count, 1);
    for (entry, weight) in entries.iter().zip(weights) {
        let mut terms = vec![(count - 1, if entry.timed { -1.0 } else { 0.0 })];
        // A diagonal entry depends on the rate alone.
        if entry.row != entry.column {
            terms.extend([(entry.column, 1.0), (entry.row, -1.0)]);
        }
        for &(i, by_i) in &terms {
            right[(i, 0)] -= weight * by_i * entry.size;
            for &(j, by_j) in &terms {
                normal[(i, j)] += weight * by_i * by_j;
            }
        }
    }
    let units = normal.lu().solve(&right);
    let sound = |unit: f64| if unit.is_finite() { unit } else { 0.0 };
    (0..count).map(|i| sound(units[(i, 0)])).collect()
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}

/// The nearest power of two; one for what has no size.
fn power_of_two(size: f64) -> f64 {
    if size.is_normal() && 0.0 < size { size.log2().round().exp2() } else { 1.0 }
}
