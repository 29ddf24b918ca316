//! Deviations from an operating point in units of a scale, and back.

use serde::{Deserialize, Serialize};

use crate::{
    channel::Channel,
    record::{Record, RecordError},
};

/// Operating point and scale of each channel: `ṽ = (v − offset) / scale`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scaling {
    /// One entry per input.
    pub inputs: Vec<ChannelScale>,
    /// One entry per output.
    pub outputs: Vec<ChannelScale>,
}

/// Operating point and scale of one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelScale {
    /// Operating point, in the unit of the channel.
    #[serde(default)]
    pub offset: f64,
    /// What counts as one per unit, in the unit of the channel; without it deviations stay in
    /// the unit of the channel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
}

impl ChannelScale {
    /// Deviations from `offset` in units of `scale`.
    ///
    /// ```
    /// # use fd_model::ChannelScale;
    /// let speed = ChannelScale::per_unit(9000.0, 10_000.0);
    /// assert_eq!(speed.scaled(9500.0), 0.05);
    /// ```
    #[must_use]
    pub fn per_unit(offset: f64, scale: f64) -> Self {
        Self { offset, scale: Some(scale) }
    }

    /// Deviations from `offset` in the unit of the channel.
    ///
    /// ```
    /// # use fd_model::ChannelScale;
    /// assert_eq!(ChannelScale::deviation(300.0).scaled(301.0), 1.0);
    /// ```
    #[must_use]
    pub fn deviation(offset: f64) -> Self {
        Self { offset, scale: None }
    }

    /// `(v − offset) / scale`.
    #[must_use]
    pub fn scaled(&self, v: f64) -> f64 {
        (v - self.offset) / self.scale.unwrap_or(1.0)
    }

    /// `offset + scale · v`.
    #[must_use]
    pub fn physical(&self, v: f64) -> f64 {
        self.offset + self.scale.unwrap_or(1.0) * v
    }

    /// Unit of the scaled channel.
    fn unit(&self, channel: &Channel) -> String {
        if self.scale.is_some() { "pu".to_owned() } else { channel.unit.clone() }
    }
}

impl Record {
    /// Deviations from the operating point, in units of the scales; scaled channels have the
    /// unit `pu`.
    ///
    /// ```
    /// # use fd_model::{Channel, ChannelScale, Record, SampleTime, Scaling};
    /// let t7 = vec![Channel::new("T_7", "K")];
    /// let record = Record::new(vec![], t7, vec![], vec![900.0, 909.0], SampleTime::new(1.0)?)?;
    /// let scaling =
    ///     Scaling { inputs: vec![], outputs: vec![ChannelScale::per_unit(900.0, 900.0)] };
    /// let per_unit = record.scaled(&scaling)?;
    /// assert_eq!(per_unit.y(1), [0.01]);
    /// assert_eq!(per_unit.outputs()[0].unit, "pu");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when there is not one entry per channel, or a scale is zero or not
    /// finite.
    pub fn scaled(&self, scaling: &Scaling) -> Result<Self, RecordError> {
        self.check_scaling(scaling)?;
        let units = |channels: &[Channel], scales: &[ChannelScale]| {
            let pairs = channels.iter().zip(scales);
            pairs.map(|(channel, s)| Channel::new(channel.name.clone(), s.unit(channel))).collect()
        };
        Ok(Self {
            inputs: units(&self.inputs, &scaling.inputs),
            outputs: units(&self.outputs, &scaling.outputs),
            u: map_columns(&self.u, &scaling.inputs, ChannelScale::scaled),
            y: map_columns(&self.y, &scaling.outputs, ChannelScale::scaled),
            ..*self
        })
    }

    /// The inverse of [`Record::scaled`]; the channels bring the physical units.
    ///
    /// # Errors
    ///
    /// As [`Record::scaled`], and when the channels do not have the names of those of the record.
    pub fn unscaled(
        &self,
        scaling: &Scaling,
        inputs: &[Channel],
        outputs: &[Channel],
    ) -> Result<Self, RecordError> {
        self.check_scaling(scaling)?;
        for (role, own, physical) in
            [("input", &self.inputs, inputs), ("output", &self.outputs, outputs)]
        {
            for index in 0..own.len().max(physical.len()) {
                let name = |channels: &[Channel]| {
                    channels.get(index).map_or("none".to_owned(), |c| c.name.clone())
                };
                let (expected, found) = (name(own), name(physical));
                if expected != found {
                    return Err(RecordError::Channel { role, index, expected, found });
                }
            }
        }
        Ok(Self {
            inputs: inputs.to_vec(),
            outputs: outputs.to_vec(),
            u: map_columns(&self.u, &scaling.inputs, ChannelScale::physical),
            y: map_columns(&self.y, &scaling.outputs, ChannelScale::physical),
            ..*self
        })
    }

    fn check_scaling(&self, scaling: &Scaling) -> Result<(), RecordError> {
        let roles =
            [("input", &self.inputs, &scaling.inputs), ("output", &self.outputs, &scaling.outputs)];
        for (role, channels, scales) in roles {
            let (expected, found) = (channels.len(), scales.len());
            if expected != found {
                return Err(RecordError::Count { role, what: "scale", expected, found });
            }
            for (channel, scale) in channels.iter().zip(scales) {
                let value = scale.scale.unwrap_or(1.0);
                if !value.is_normal() {
                    let channel = channel.name.clone();
                    return Err(RecordError::Scale { role, channel, value });
                }
            }
        }
        Ok(())
    }
}

/// Applies one function per column to row-major values.
pub(super) fn map_columns<S>(
    values: &[f64],
    columns: &[S],
    f: impl Fn(&S, f64) -> f64,
) -> Vec<f64> {
    values.iter().zip(columns.iter().cycle()).map(|(&v, column)| f(column, v)).collect()
}
