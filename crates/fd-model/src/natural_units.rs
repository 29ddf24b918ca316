//! Units of all signals in which a model has entries of like size.

use faer::{Mat, MatRef};

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
    /// Units in which each column of `[B; D]` and each row of `C` has unit size, and in which what
    /// enters a state, from the other states and the inputs, is as large as what leaves it.
    ///
    /// Balancing of the system matrix (Osborne 1960; Parlett and Reinsch 1969) with the inputs and
    /// outputs as part of it: without feedthrough the minimum of a convex function of the logarithms,
    /// so that the answer does not depend on the units to begin with.
    ///
    /// Nothing is gained from entries that are rounding next to the others of their row and column: they
    /// have no part in it. A state that nothing reaches, or that nothing shows, keeps its unit; couplings
    /// weaker than a ten-thousandth of the rate are not stretched any further.
    #[must_use]
    pub fn natural_units(&self) -> NaturalUnits {
        const SWEEPS: usize = 100;
        /// Squares of couplings that need no balance, next to the squared rate.
        const WEAK: f64 = 1e-8;
        /// A twentieth of an octave is less than what rounding to powers of two changes.
        const SETTLED: f64 = 0.05;
        /// Octaves that no unit goes beyond, for groups of states that nothing reaches or shows.
        const FARTHEST: f64 = 40.0;

        let n = self.nx();
        let clean = self.without_rounding();
        let mut states = vec![1.0; n];
        for _ in 0..SWEEPS {
            let now = clean.signal_units(states.clone());
            let (into, out) = (clean.shares_in(&now), clean.shares_out(&now));
            let mut farthest = 0.0_f64;
            for i in 0..n {
                let others = || (0..n).filter(move |&j| j != i);
                let square = |v: f64| (v / now.rate).powi(2);
                let row = others().map(|j| square(clean.a[(i, j)] * states[j] / states[i]));
                let col = others().map(|j| square(clean.a[(j, i)] * states[i] / states[j]));
                let (row, col) = (row.sum::<f64>() + into[i], col.sum::<f64>() + out[i]);
                let octaves = ((row + WEAK) / (col + WEAK)).log2() / 4.0;
                if 0.0 < row && 0.0 < col && octaves.is_finite() {
                    states[i] *= octaves.exp2();
                    farthest = farthest.max(octaves.abs());
                }
            }
            // A common factor of all states changes nothing.
            let mean = states.iter().map(|s| s.log2()).sum::<f64>() / n as f64;
            for s in &mut states {
                *s = (s.log2() - mean).clamp(-FARTHEST, FARTHEST).exp2();
            }
            if farthest < SETTLED {
                break;
            }
        }
        clean.signal_units(states.into_iter().map(power_of_two).collect())
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

    /// Mean over the inputs of the squared share of each that enters each state.
    fn shares_in(&self, units: &NaturalUnits) -> Vec<f64> {
        let (n, m) = (self.nx(), self.nu());
        if m == 0 {
            // As if each state had an input of its own.
            return vec![1.0 / n as f64; n];
        }
        let entry =
            |i: usize, j: usize| self.b()[(i, j)] * units.inputs[j] / units.states[i] / units.rate;
        let share = |i: usize| (0..m).map(|j| entry(i, j).powi(2)).sum::<f64>() / m as f64;
        (0..n).map(share).collect()
    }

    /// Mean over the outputs of the squared share of each that each state gives it.
    fn shares_out(&self, units: &NaturalUnits) -> Vec<f64> {
        let (n, p) = (self.nx(), self.ny());
        if p == 0 {
            return vec![1.0 / n as f64; n];
        }
        let entry = |i: usize, j: usize| self.c()[(i, j)] * units.states[j] / units.outputs[i];
        let share = |j: usize| (0..p).map(|i| entry(i, j).powi(2)).sum::<f64>() / p as f64;
        (0..n).map(share).collect()
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

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}

/// The nearest power of two; one for what has no size.
fn power_of_two(size: f64) -> f64 {
    if size.is_normal() && 0.0 < size { size.log2().round().exp2() } else { 1.0 }
}
