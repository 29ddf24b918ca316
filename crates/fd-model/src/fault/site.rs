//! Where a fault sits, and how plants let their parameters be moved.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{channel::Channel, fault::error::FaultError};

/// A channel by its name or its index from 0.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ChannelRef {
    /// Index, from 0.
    Index(usize),
    /// Name.
    Name(String),
}

/// Where a fault sits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Site {
    /// An output channel.
    Sensor(ChannelRef),
    /// An input channel.
    Actuator(ChannelRef),
    /// A parameter of the plant.
    Component(ChannelRef),
}

/// A plant whose parameters (efficiencies, gains, leakages, …) can be moved while it runs.
///
/// A component fault acts on the nominal value that the plant has when the simulation begins.
///
/// It is a power beside [`Plant`](fd_core::stage::Plant), for those plants that have something to move. The
/// plant is cloned for each run, so the one that was handed in keeps its nominal values.
///
/// ```
/// use fd_core::{IoDims, stage::Plant};
/// use fd_model::{
///     Channel, Inputs, SampleTime, Simulation,
///     fault::{FaultProfile, FaultSpec, Parameters, Site},
///     signal::Step,
/// };
///
/// /// A valve that passes `gain` times its opening.
/// #[derive(Clone, Debug)]
/// struct Valve {
///     gain: f64,
/// }
///
/// impl Plant for Valve {
///     fn nx(&self) -> usize { 0 }
///     fn io(&self) -> IoDims { IoDims { nu: 1, ny: 1 } }
///     fn advance(&self, _x: &[f64], _u: &[f64], _x_next: &mut [f64]) {}
///     fn output(&self, _x: &[f64], u: &[f64], y: &mut [f64]) { y[0] = self.gain * u[0]; }
/// }
///
/// impl Parameters for Valve {
///     fn parameter_names(&self) -> Vec<String> { vec!["gain".to_owned()] }
///     fn parameter(&self, _index: usize) -> f64 { self.gain }
///     fn set_parameter(&mut self, _index: usize, value: f64) { self.gain = value; }
/// }
///
/// let (valve, ts) = (Valve { gain: 2.0 }, SampleTime::new(1.0)?);
/// let inputs = Inputs::from_signals([(Channel::new("opening", "1"), Step::new(1.0, 0.0))], 4, ts)?;
/// let clogged = FaultSpec::add(Site::component("gain"), 2.0, FaultProfile::abrupt(-0.5));
/// let run = Simulation { faults: vec![clogged], ..Simulation::default() };
/// let log = run.run_with_parameters(&valve, &inputs, vec![Channel::new("flow", "l/s")])?;
/// assert_eq!(log.output(0).collect::<Vec<_>>(), [2.0, 2.0, 1.5, 1.5]);
/// assert_eq!(valve.gain, 2.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Parameters {
    /// Names of the parameters.
    fn parameter_names(&self) -> Vec<String>;

    /// Value of parameter `index` in the order of the names.
    fn parameter(&self, index: usize) -> f64;

    /// Sets parameter `index` in the order of the names.
    fn set_parameter(&mut self, index: usize, value: f64);
}

impl Site {
    /// A sensor by name or index.
    ///
    /// ```
    /// # use fd_model::fault::Site;
    /// assert_ne!(Site::sensor("T_7"), Site::sensor(3));
    /// ```
    pub fn sensor(channel: impl Into<ChannelRef>) -> Self {
        Self::Sensor(channel.into())
    }

    /// An actuator by name or index.
    ///
    /// ```
    /// # use fd_model::fault::Site;
    /// assert_ne!(Site::actuator("fuel"), Site::sensor("fuel"));
    /// ```
    pub fn actuator(channel: impl Into<ChannelRef>) -> Self {
        Self::Actuator(channel.into())
    }

    /// A parameter of the plant by name or index.
    ///
    /// ```
    /// # use fd_model::fault::Site;
    /// assert_eq!(Site::component("eta").to_string(), "component `eta`");
    /// ```
    pub fn component(parameter: impl Into<ChannelRef>) -> Self {
        Self::Component(parameter.into())
    }

    /// `"sensor"`, `"actuator"` or `"component"`.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sensor(_) => "sensor",
            Self::Actuator(_) => "actuator",
            Self::Component(_) => "component",
        }
    }

    /// The signal or parameter, whatever its kind.
    #[must_use]
    pub fn target(&self) -> &ChannelRef {
        match self {
            Self::Sensor(target) | Self::Actuator(target) | Self::Component(target) => target,
        }
    }

    /// Index of the target among the given names.
    ///
    /// ```
    /// # use fd_model::fault::Site;
    /// assert_eq!(Site::sensor("T_7").index_among(&["N", "T_7"])?, 1);
    /// assert!(Site::sensor(2).index_among(&["N", "T_7"]).is_err());
    /// # Ok::<(), fd_model::fault::FaultError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such name or index.
    pub fn index_among(&self, names: &[&str]) -> Result<usize, FaultError> {
        let site = self.kind();
        match self.target() {
            ChannelRef::Index(index) if *index < names.len() => Ok(*index),
            ChannelRef::Index(index) => {
                Err(FaultError::UnknownIndex { site, index: *index, count: names.len() })
            }
            ChannelRef::Name(name) => {
                names.iter().position(|known| known == name).ok_or_else(|| {
                    let known = names.iter().map(|&name| name.to_owned()).collect();
                    FaultError::UnknownName { site, name: name.clone(), known }
                })
            }
        }
    }

    /// Index of the target among channels.
    pub(crate) fn channel_among(&self, channels: &[Channel]) -> Result<usize, FaultError> {
        let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
        self.index_among(&names)
    }
}

impl fmt::Display for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} `{}`", self.kind(), self.target())
    }
}

impl fmt::Display for ChannelRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Index(index) => write!(f, "{index}"),
            Self::Name(name) => f.write_str(name),
        }
    }
}

impl From<usize> for ChannelRef {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

impl From<&str> for ChannelRef {
    fn from(name: &str) -> Self {
        Self::Name(name.to_owned())
    }
}

impl From<String> for ChannelRef {
    fn from(name: String) -> Self {
        Self::Name(name)
    }
}
