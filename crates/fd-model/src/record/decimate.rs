//! Thinning of records by averages.

use crate::{
    domain::SampleTime,
    record::{Record, RecordError},
};

impl Record {
    /// Replaces every `factor` samples by their mean, which keeps most of what is above the new
    /// half sample rate from being folded below it; samples left over at the end are dropped.
    ///
    /// The mean is a filter with zeros at multiples of the new sample rate and −3.9 dB at half of
    /// it. It belongs to the middle of the samples it covers, and so does its time. A mean over
    /// a missing value is missing.
    ///
    /// ```
    /// # use fd_model::{Channel, Record, SampleTime};
    /// let y = vec![1.0, 3.0, 5.0, 7.0, 9.0];
    /// let record =
    ///     Record::new(vec![], Channel::numbered("y", 1), vec![], y, SampleTime::new(1.0)?)?;
    /// let thin = record.decimated(2)?;
    /// assert_eq!((thin.y(0), thin.y(1), thin.len()), (&[2.0][..], &[6.0][..], 2));
    /// assert_eq!((thin.time(0), thin.ts().seconds()), (0.5, 2.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when `factor` is 0, or so large that the sample time overflows.
    pub fn decimated(&self, factor: usize) -> Result<Self, RecordError> {
        let seconds = self.ts().seconds() * factor as f64;
        let ts = SampleTime::new(seconds).map_err(|_| RecordError::Factor { factor })?;
        let thin = |values: &[f64], width: usize| -> Vec<f64> {
            (0..self.len() / factor)
                .flat_map(|group| (0..width).map(move |channel| (group, channel)))
                .map(|(group, channel)| {
                    let rows = group * factor..(group + 1) * factor;
                    rows.map(|k| values[k * width + channel]).sum::<f64>() / factor as f64
                })
                .collect()
        };
        Ok(Self {
            u: thin(&self.u, self.inputs.len()),
            y: thin(&self.y, self.outputs.len()),
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            ts,
            start: self.start + 0.5 * (factor as f64 - 1.0) * self.ts.seconds(),
            before: self.before / factor,
        })
    }
}
