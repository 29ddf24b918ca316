//! Joining of records in time.

use crate::{
    channel::Channel,
    record::{Record, RecordError},
};

impl Record {
    /// This record followed by a later one; the time between the two, if any, is missing.
    ///
    /// The later record must begin on the time base of this one, to within a thousandth of a
    /// sample, and not before this one ends. Joining runs that do not belong to one time axis
    /// would feign a jump of the plant: keep those as separate records.
    ///
    /// ```
    /// # use fd_model::{Channel, Record, SampleTime};
    /// let ts = SampleTime::new(1.0)?;
    /// let run = |y: Vec<f64>| Record::new(vec![], Channel::numbered("y", 1), vec![], y, ts);
    /// let joined = run(vec![1.0])?.followed_by(&run(vec![3.0])?.starting_at(2.0))?;
    /// assert_eq!(joined.y(2), [3.0]);
    /// assert!(joined.y(1)[0].is_nan());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns what differs between the records, or that the later one begins too early or
    /// between two samples.
    pub fn followed_by(&self, later: &Self) -> Result<Self, RecordError> {
        same_channels("input", &self.inputs, &later.inputs)?;
        same_channels("output", &self.outputs, &later.outputs)?;
        let (ts, later_ts) = (self.ts.seconds(), later.ts.seconds());
        if 1e-9 * ts < (ts - later_ts).abs() {
            return Err(RecordError::SampleTime { expected_s: ts, found_s: later_ts });
        }
        let end = self.time(self.len());
        let hole = (later.start - end) / ts;
        if hole < -1e-3 || 1e-3 < (hole - hole.round()).abs() {
            return Err(RecordError::Order { expected_s: end, found_s: later.start });
        }
        // Saturates for holes beyond any memory.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let hole = hole.round().max(0.0) as usize;
        let join = |first: &[f64], second: &[f64], width: usize| {
            let missing = std::iter::repeat_n(f64::NAN, hole * width);
            first.iter().copied().chain(missing).chain(second.iter().copied()).collect()
        };
        Ok(Self {
            u: join(&self.u, &later.u, self.inputs.len()),
            y: join(&self.y, &later.y, self.outputs.len()),
            ..self.clone()
        })
    }
}

fn same_channels(
    role: &'static str,
    first: &[Channel],
    second: &[Channel],
) -> Result<(), RecordError> {
    let name = |channel: Option<&Channel>| channel.map_or("none".to_owned(), Channel::to_string);
    for index in 0..first.len().max(second.len()) {
        let (a, b) = (first.get(index), second.get(index));
        if a != b {
            return Err(RecordError::Channel { role, index, expected: name(a), found: name(b) });
        }
    }
    Ok(())
}
