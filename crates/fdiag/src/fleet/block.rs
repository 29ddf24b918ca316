//! Samples of a fleet, laid out as its parts use them.

use fd_core::{IoDims, Scalar};

/// Units that are computed side by side.
pub(super) const PART: usize = 128;

/// Some samples `(u, y)` of each unit of a fleet.
///
/// A number that is not finite is missing: the unit holds the last good one, and neither learns nor
/// judges that sample. So are all numbers of a new block.
///
/// # Examples
///
/// ```
/// use fdiag::{core::IoDims, fleet::FleetBlock};
///
/// let mut block = FleetBlock::<f32>::new(IoDims { nu: 1, ny: 2 }, 300, 10);
/// block.set(299, 9, &[0.5], &[1.0, 2.0]);
/// assert_eq!((block.units(), block.steps()), (300, 10));
/// ```
#[derive(Clone, Debug)]
pub struct FleetBlock<T> {
    io: IoDims,
    units: usize,
    steps: usize,
    /// For each part, for each sample: a row of units per channel of `[u; y]`.
    rows: Vec<T>,
}

impl<T: Scalar> FleetBlock<T> {
    /// Room for `steps` samples of each unit, all of them missing.
    #[must_use]
    pub fn new(io: IoDims, units: usize, steps: usize) -> Self {
        let numbers = units.div_ceil(PART) * steps * (io.nu + io.ny) * PART;
        Self { io, units, steps, rows: vec![T::zero() / T::zero(); numbers] }
    }

    /// Channels of a unit.
    #[must_use]
    pub fn io(&self) -> IoDims {
        self.io
    }

    /// Number of units.
    #[must_use]
    pub fn units(&self) -> usize {
        self.units
    }

    /// Samples per unit.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Writes sample `step` of one unit.
    ///
    /// # Panics
    ///
    /// Panics when there is no such unit or step.
    pub fn set(&mut self, unit: usize, step: usize, u: &[T], y: &[T]) {
        let channels = self.io.nu + self.io.ny;
        let first = (unit / PART * self.steps + step) * channels * PART;
        let rows = self.rows[first..first + channels * PART].chunks_exact_mut(PART);
        for (row, &value) in rows.zip(u.iter().chain(y)) {
            row[unit % PART] = value;
        }
    }

    /// The samples of each part, each sample by itself.
    pub(super) fn parts(&self) -> impl Iterator<Item = Samples<'_, T>> {
        let channels = self.io.nu + self.io.ny;
        let per_part = (self.steps * channels * PART).max(1);
        let samples = move |rows| Samples { rows, per_sample: channels * PART };
        self.rows.chunks(per_part).map(samples)
    }
}

/// The samples of one part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Samples<'a, T> {
    rows: &'a [T],
    per_sample: usize,
}

impl<'a, T> Samples<'a, T> {
    pub(super) fn len(self) -> usize {
        self.rows.len() / self.per_sample.max(1)
    }

    /// Rows of units, one per channel of `[u; y]`.
    pub(super) fn sample(self, step: usize) -> &'a [T] {
        &self.rows[step * self.per_sample..(step + 1) * self.per_sample]
    }
}
