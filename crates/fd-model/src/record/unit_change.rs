//! Conversion of the channels of a record to other units.

use crate::{
    channel::Channel,
    record::{Record, RecordError, scaling::map_columns},
    unit::Conversion,
};

impl Record {
    /// The same signals in other units, one per channel.
    ///
    /// ```
    /// # use fd_model::{Channel, Record, SampleTime};
    /// let t7 = vec![Channel::new("T_7", "degC")];
    /// let record = Record::new(vec![], t7, vec![], vec![26.85], SampleTime::new(1.0)?)?;
    /// assert!((record.in_units(&[], &["K"])?.y(0)[0] - 300.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when there is not one unit per channel, or a unit does not measure what
    /// the channel's unit measures.
    pub fn in_units(&self, inputs: &[&str], outputs: &[&str]) -> Result<Self, RecordError> {
        let to_inputs = conversions("input", &self.inputs, inputs)?;
        let to_outputs = conversions("output", &self.outputs, outputs)?;
        let renamed = |channels: &[Channel], units: &[&str]| {
            let pairs = channels.iter().zip(units);
            pairs.map(|(channel, &unit)| Channel::new(channel.name.clone(), unit)).collect()
        };
        Ok(Self {
            inputs: renamed(&self.inputs, inputs),
            outputs: renamed(&self.outputs, outputs),
            u: map_columns(&self.u, &to_inputs, Conversion::apply),
            y: map_columns(&self.y, &to_outputs, Conversion::apply),
            ..*self
        })
    }
}

fn conversions(
    role: &'static str,
    channels: &[Channel],
    units: &[&str],
) -> Result<Vec<Conversion>, RecordError> {
    if channels.len() != units.len() {
        let (expected, found) = (channels.len(), units.len());
        return Err(RecordError::Count { role, what: "unit", expected, found });
    }
    let pairs = channels.iter().zip(units);
    pairs
        .map(|(channel, unit)| {
            Conversion::between(&channel.unit, unit).map_err(|source| RecordError::Unit {
                role,
                channel: channel.name.clone(),
                source,
            })
        })
        .collect()
}
