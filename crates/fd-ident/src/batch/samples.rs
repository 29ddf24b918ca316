//! Samples of many estimators, laid out as the estimators are.

use fd_numeric::lanes::LaneScalar;

/// Some samples `(φ, y)` for each of many estimators, or `(u, μ)` for estimators that make their
/// regressors themselves.
///
/// The longer the block, the less of the time goes into fetching the estimators from memory; some
/// dozen samples are enough. A sample that is not finite is a missing one; so are all samples of a
/// new block.
///
/// # Examples
///
/// ```
/// use fd_ident::batch::SampleBlock;
///
/// let mut block = SampleBlock::<f64>::new(2, 10, 3);
/// block.set(9, 0, &[1.0, 2.0], 3.0);
/// assert_eq!((block.columns(), block.estimators(), block.steps()), (2, 10, 3));
/// ```
#[derive(Clone, Debug)]
pub struct SampleBlock<T: LaneScalar> {
    columns: usize,
    estimators: usize,
    steps: usize,
    /// For each tile, for each sample: a row per column and one of targets.
    rows: Vec<T::Row>,
}

impl<T: LaneScalar> SampleBlock<T> {
    /// Room for `steps` samples of each estimator, all of them missing. Besides its target each
    /// sample has `columns` numbers: one per parameter, or one per input.
    #[must_use]
    pub fn new(columns: usize, estimators: usize, steps: usize) -> Self {
        let rows = estimators.div_ceil(T::WIDTH) * steps * (columns + 1);
        let missing = T::zero() / T::zero();
        Self { columns, estimators, steps, rows: vec![T::row(missing); rows] }
    }

    /// Numbers per sample besides the target: parameters, or inputs.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Number of estimators.
    #[must_use]
    pub fn estimators(&self) -> usize {
        self.estimators
    }

    /// Samples per estimator.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Writes sample `step` of one estimator; `phi` has one number per column.
    ///
    /// # Panics
    ///
    /// Panics when there is no such estimator or step.
    pub fn set(&mut self, estimator: usize, step: usize, phi: &[T], target: T) {
        self.write(estimator, step, phi.iter().copied().take(self.columns).chain([target]));
    }

    /// Writes sample `step` of all estimators: `phi` has one number per estimator for each column,
    /// column by column, and `targets` one per estimator.
    ///
    /// # Panics
    ///
    /// Panics when there is no such step, or numbers are missing.
    pub fn set_all(&mut self, step: usize, phi: &[T], targets: &[T]) {
        let per_tile = self.steps * (self.columns + 1);
        let sample = step * (self.columns + 1)..(step + 1) * (self.columns + 1);
        for (tile, rows) in self.rows.chunks_exact_mut(per_tile).enumerate() {
            let rows = &mut rows[sample.clone()];
            let first = tile * T::WIDTH;
            let last = (first + T::WIDTH).min(self.estimators);
            for (column, row) in rows.iter_mut().enumerate() {
                let numbers =
                    if column < self.columns { &phi[column * self.estimators..] } else { targets };
                row.as_mut()[..last - first].copy_from_slice(&numbers[first..last]);
            }
        }
    }

    /// Makes room for `steps` samples of each estimator, all of them missing. Allocates only when
    /// there have never been so many.
    pub fn restart(&mut self, steps: usize) {
        let missing = T::row(T::zero() / T::zero());
        self.steps = steps;
        self.rows.clear();
        let rows = self.estimators.div_ceil(T::WIDTH) * steps * (self.columns + 1);
        self.rows.resize(rows, missing);
    }

    /// Removes sample `step` of one estimator, which will skip it.
    ///
    /// # Panics
    ///
    /// Panics when there is no such estimator or step.
    pub fn remove(&mut self, estimator: usize, step: usize) {
        self.write(estimator, step, std::iter::repeat(T::zero() / T::zero()));
    }

    fn write(&mut self, estimator: usize, step: usize, values: impl Iterator<Item = T>) {
        let (tile, lane) = (estimator / T::WIDTH, estimator % T::WIDTH);
        let first = (tile * self.steps + step) * (self.columns + 1);
        let rows = &mut self.rows[first..=first + self.columns];
        for (row, value) in rows.iter_mut().zip(values) {
            row.as_mut()[lane] = value;
        }
    }

    pub(super) fn rows(&self) -> &[T::Row] {
        &self.rows
    }
}
