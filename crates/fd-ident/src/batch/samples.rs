//! Samples of many estimators, laid out as the estimators are.

use super::lanes::{LaneScalar, sealed::Lanes};

/// Some samples `(φ, y)` for each of many estimators.
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
/// assert_eq!((block.parameters(), block.estimators(), block.steps()), (2, 10, 3));
/// ```
#[derive(Clone, Debug)]
pub struct SampleBlock<T: LaneScalar> {
    parameters: usize,
    estimators: usize,
    steps: usize,
    /// For each tile, for each sample: a row per parameter and one of targets.
    rows: Vec<<T as Lanes>::Row>,
}

impl<T: LaneScalar> SampleBlock<T> {
    /// Room for `steps` samples of each estimator, all of them missing.
    #[must_use]
    pub fn new(parameters: usize, estimators: usize, steps: usize) -> Self {
        let rows = estimators.div_ceil(T::WIDTH) * steps * (parameters + 1);
        let missing = T::zero() / T::zero();
        Self { parameters, estimators, steps, rows: vec![T::row(missing); rows] }
    }

    /// Number of parameters.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.parameters
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

    /// Writes sample `step` of one estimator; `phi` has one number per parameter.
    pub fn set(&mut self, estimator: usize, step: usize, phi: &[T], target: T) {
        self.write(estimator, step, phi.iter().copied().take(self.parameters).chain([target]));
    }

    /// Removes sample `step` of one estimator, which will skip it.
    pub fn remove(&mut self, estimator: usize, step: usize) {
        self.write(estimator, step, std::iter::repeat(T::zero() / T::zero()));
    }

    fn write(&mut self, estimator: usize, step: usize, values: impl Iterator<Item = T>) {
        let (tile, lane) = (estimator / T::WIDTH, estimator % T::WIDTH);
        let first = (tile * self.steps + step) * (self.parameters + 1);
        let rows = &mut self.rows[first..=first + self.parameters];
        for (row, value) in rows.iter_mut().zip(values) {
            row.as_mut()[lane] = value;
        }
    }

    pub(super) fn rows(&self) -> &[<T as Lanes>::Row] {
        &self.rows
    }
}
