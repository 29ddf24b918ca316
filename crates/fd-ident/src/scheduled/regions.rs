//! Regions of the operating range and how much each of them counts.

use std::borrow::Borrow;

use fd_core::{Scalar, StateVisitor, stage::Stage};
use fd_model::Record;

use crate::{arx::check_records, error::IdentError};

/// Regions along a slow copy of one input.
///
/// # Examples
///
/// ```
/// use fd_ident::scheduled::Regions;
///
/// let regions = Regions::new(0, 20.0, vec![0.5, 0.7, 0.9])?;
/// assert_eq!(regions.len(), 3);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    input: usize,
    time_constant: f64,
    centres: Vec<f64>,
}

impl Regions {
    /// Regions around the given centres, in increasing order, of an input that is slowed down by
    /// a time constant in samples.
    ///
    /// # Errors
    ///
    /// Returns an error when there are no centres or they do not increase, or when the time
    /// constant is negative.
    pub fn new(input: usize, time_constant: f64, centres: Vec<f64>) -> Result<Self, IdentError> {
        if !(time_constant >= 0.0 && time_constant.is_finite()) {
            let (setting, expected) = ("time constant of the schedule", "finite, not negative");
            return Err(IdentError::Setting { setting, expected, found: time_constant });
        }
        let ordered = centres.windows(2).all(|pair| pair[0] < pair[1]);
        if centres.is_empty() || !ordered || centres.iter().any(|c| !c.is_finite()) {
            let (setting, expected) = ("number of centres", "at least 1, finite and increasing");
            return Err(IdentError::Setting { setting, expected, found: centres.len() as f64 });
        }
        Ok(Self { input, time_constant, centres })
    }

    /// Regions spread evenly over the range of the slow input in training data, the outer centres
    /// half a spacing inside its ends.
    ///
    /// # Errors
    ///
    /// As [`Regions::new`], and when the records do not have the input or it does not move.
    pub fn from_training<R: Borrow<Record>>(
        input: usize,
        time_constant: f64,
        count: usize,
        records: &[R],
    ) -> Result<Self, IdentError> {
        let first = check_records(records)?;
        if input >= first.inputs().len() {
            let (setting, expected) = ("scheduling input", "below the number of inputs");
            return Err(IdentError::Setting { setting, expected, found: input as f64 });
        }
        let probe = Self::new(input, time_constant, vec![0.0])?;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for record in records {
            for slow in probe.slow(record.borrow()) {
                (low, high) = (low.min(slow), high.max(slow));
            }
        }
        let step = (high - low) / count.max(1) as f64;
        let centres = (0..count).map(|i| low + (i as f64 + 0.5) * step).collect();
        Self::new(input, time_constant, centres)
    }

    /// Number of regions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.centres.len()
    }

    /// Whether there are no regions; never, after [`Regions::new`].
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.centres.is_empty()
    }

    /// The centres.
    #[must_use]
    pub fn centres(&self) -> &[f64] {
        &self.centres
    }

    /// The input that schedules.
    #[must_use]
    pub fn input(&self) -> usize {
        self.input
    }

    /// Moves the regions to run time.
    #[must_use]
    pub fn freeze<T: Scalar>(&self) -> Scheduler<T> {
        Scheduler {
            input: self.input,
            gain: T::from_design((1.0 + self.time_constant).recip()),
            centres: self.centres.iter().map(|&c| T::from_design(c)).collect(),
            weights: vec![T::zero(); self.centres.len()],
            slow: T::zero(),
            begun: 0,
        }
    }

    /// The slow input over a record, NaN before the first sample that is there.
    fn slow(&self, record: &Record) -> Vec<f64> {
        let mut scheduler = self.freeze::<f64>();
        (0..record.len())
            .map(|k| {
                scheduler.step(record.u(k));
                if scheduler.begun == 0 { f64::NAN } else { scheduler.slow }
            })
            .collect()
    }

    /// The record as one region learns from it: the bias is missing wherever another region is
    /// nearer.
    pub(super) fn seen_from(&self, region: usize, record: &Record) -> Record {
        let mut scheduler = self.freeze::<f64>();
        let mut seen = record.clone();
        for k in 0..record.len() {
            scheduler.step(record.u(k));
            if scheduler.nearest() != region {
                seen.y_mut(k).fill(f64::NAN);
            }
        }
        seen
    }
}

/// The slow input and the weights of the regions, sample by sample.
#[derive(Clone, Debug)]
pub struct Scheduler<T> {
    input: usize,
    gain: T,
    centres: Vec<T>,
    weights: Vec<T>,
    slow: T,
    /// 1 after the first sample.
    begun: u64,
}

impl<T: Scalar> Scheduler<T> {
    /// Follows one sample and returns the weights, which sum to 1. A missing input is held.
    pub fn step(&mut self, u: &[T]) -> &[T] {
        let u = u[self.input];
        if u.is_finite() {
            let gain = if self.begun == 0 { T::one() } else { self.gain };
            self.slow += gain * (u - self.slow);
            self.begun = 1;
        }
        self.weigh();
        &self.weights
    }

    /// The region that counts most; the lower one of two that count the same.
    #[must_use]
    pub fn nearest(&self) -> usize {
        let mut nearest = 0;
        for (region, weight) in self.weights.iter().enumerate() {
            if *weight > self.weights[nearest] {
                nearest = region;
            }
        }
        nearest
    }

    fn weigh(&mut self) {
        self.weights.fill(T::zero());
        let last = self.centres.len() - 1;
        let above = self.centres.iter().position(|&c| self.slow < c);
        match above {
            Some(0) => self.weights[0] = T::one(),
            None => self.weights[last] = T::one(),
            Some(above) => {
                let (left, right) = (self.centres[above - 1], self.centres[above]);
                let share = (self.slow - left) / (right - left);
                self.weights[above] = share;
                self.weights[above - 1] = T::one() - share;
            }
        }
    }
}

impl<T: Scalar> Stage<T> for Scheduler<T> {
    fn reset(&mut self) {
        self.weights.fill(T::zero());
        self.slow = T::zero();
        self.begun = 0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("scheduling input", std::slice::from_mut(&mut self.slow));
        visitor.reals("region weights", &mut self.weights);
        let mut counts = [self.begun];
        visitor.counts("schedule begun", &mut counts);
        [self.begun] = counts;
    }
}
