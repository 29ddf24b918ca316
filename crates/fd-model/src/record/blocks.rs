//! Missing samples: how many there are, and the stretches between them.

use crate::record::Record;

/// Where a record has holes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingCounts {
    /// Samples in which every channel is there.
    pub complete: usize,
    /// Missing values per input.
    pub inputs: Vec<usize>,
    /// Missing values per output.
    pub outputs: Vec<usize>,
    /// Longest run of samples with at least one missing value.
    pub longest_hole: usize,
}

impl Record {
    /// Counts what is missing.
    ///
    /// ```
    /// # use fd_model::{Channel, Record, SampleTime};
    /// let y = vec![1.0, f64::NAN, f64::NAN, 4.0];
    /// let record =
    ///     Record::new(vec![], Channel::numbered("y", 1), vec![], y, SampleTime::new(1.0)?)?;
    /// let missing = record.missing();
    /// assert_eq!((missing.complete, missing.longest_hole), (2, 2));
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    #[must_use]
    pub fn missing(&self) -> MissingCounts {
        let mut missing = MissingCounts {
            complete: 0,
            inputs: vec![0; self.inputs().len()],
            outputs: vec![0; self.outputs().len()],
            longest_hole: 0,
        };
        let mut hole = 0;
        for k in 0..self.len() {
            count_missing(&mut missing.inputs, self.u(k));
            count_missing(&mut missing.outputs, self.y(k));
            if self.is_complete(k) {
                missing.complete += 1;
                hole = 0;
            } else {
                hole += 1;
                missing.longest_hole = missing.longest_hole.max(hole);
            }
        }
        missing
    }

    /// The stretches of at least `shortest` samples without a missing value, in order of time.
    ///
    /// ```
    /// # use fd_model::{Channel, Record, SampleTime};
    /// let y = vec![1.0, f64::NAN, 3.0, 4.0];
    /// let record =
    ///     Record::new(vec![], Channel::numbered("y", 1), vec![], y, SampleTime::new(0.5)?)?;
    /// let blocks = record.complete_blocks(2);
    /// assert_eq!((blocks.len(), blocks[0].time(0)), (1, 1.0));
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    #[must_use]
    pub fn complete_blocks(&self, shortest: usize) -> Vec<Self> {
        let mut blocks = Vec::new();
        let mut from = 0;
        while from < self.len() {
            let holes = (from..self.len()).position(|k| !self.is_complete(k));
            let to = holes.map_or(self.len(), |hole| from + hole);
            if from < to && shortest <= to - from {
                blocks.push(self.slice(from, to));
            }
            from = to + 1;
        }
        blocks
    }
}

fn count_missing(counts: &mut [usize], values: &[f64]) {
    for (count, value) in counts.iter_mut().zip(values) {
        *count += usize::from(!value.is_finite());
    }
}
