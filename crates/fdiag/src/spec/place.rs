//! The faults that an isolation thinks of, by the names of a model's channels.

use fd_model::file::ModelChannel;

use super::isolation::IsolationSpec;

/// A place that may be faulty.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultPlace {
    /// What people call it.
    pub name: String,
    /// Unit of the size of a fault there.
    pub unit: String,
    /// What a size of one is worth in that unit.
    pub scale: f64,
}

impl IsolationSpec {
    /// The places in the order of the hypotheses of the rule; none when it names no faults.
    ///
    /// ```
    /// use fdiag::{model::{Channel, file::ModelChannel}, spec::{FaultSites, IsolationSpec}};
    ///
    /// let output = [ModelChannel::from(Channel::new("T_7", "K"))];
    /// let places = IsolationSpec::Nearest { faults: FaultSites::Sensors }.places(&[], &output);
    /// assert_eq!(places.map(|places| places[0].name.clone()), Some("sensor T_7".to_owned()));
    /// assert_eq!(IsolationSpec::None {}.places(&[], &output), None);
    /// ```
    #[must_use]
    pub fn places(
        &self,
        inputs: &[ModelChannel],
        outputs: &[ModelChannel],
    ) -> Option<Vec<FaultPlace>> {
        let (Self::Nearest { faults } | Self::Bayes { faults, .. }) = self else {
            return None;
        };
        let place = |what: &str, channel: &ModelChannel| FaultPlace {
            name: format!("{what} {}", channel.channel.name),
            unit: channel.channel.unit.clone(),
            scale: channel.scale.scale.unwrap_or(1.0),
        };
        let sensors = outputs.iter().map(|channel| place("sensor", channel));
        let actuators = inputs.iter().map(|channel| place("actuator", channel));
        Some(faults.in_order(sensors, actuators).collect())
    }
}
