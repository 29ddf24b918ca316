//! A healthy log and what its samples are for.

use std::ops::Range;

use fd_model::Record;

/// A log of the healthy plant and what its samples are for.
#[derive(Clone, Debug)]
pub struct Healthy<'a> {
    /// The log.
    pub record: &'a Record,
    /// Samples that the bias is learned from.
    pub learn: Range<usize>,
    /// Samples that the detector is calibrated on.
    pub calibrate: Range<usize>,
}

impl<'a> Healthy<'a> {
    /// Learns from the first part of a log and calibrates on the rest.
    ///
    /// ```
    /// use fdiag::{model::{Channel, Record, SampleTime}, training::Healthy};
    ///
    /// let (one, ts) = (Channel::numbered("c", 1), SampleTime::new(1.0)?);
    /// let record = Record::new(one.clone(), one, vec![0.0; 10], vec![0.0; 10], ts)?;
    /// assert_eq!(Healthy::split(&record, 0.7).calibrate, 7..10);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to len")]
    pub fn split(record: &'a Record, share_to_learn: f64) -> Self {
        let cut = (record.len() as f64 * share_to_learn.clamp(0.0, 1.0)).round() as usize;
        Self { record, learn: 0..cut, calibrate: cut..record.len() }
    }

    /// Only learns from a log.
    #[must_use]
    pub fn learn(record: &'a Record) -> Self {
        Self { record, learn: 0..record.len(), calibrate: 0..0 }
    }

    /// Only calibrates on a log.
    #[must_use]
    pub fn calibrate(record: &'a Record) -> Self {
        Self { record, learn: 0..0, calibrate: 0..record.len() }
    }
}
