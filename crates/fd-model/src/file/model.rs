//! Linear models as they stand in files: matrices with named channels, units, an operating point
//! and scales.

use faer::MatRef;

use crate::{
    channel::Channel,
    domain::{Continuous, Discrete, SampleTime},
    error::ModelError,
    file::model_error::ModelFileError,
    record::{ChannelScale, Scaling},
    state_space::StateSpace,
};

/// A linear model with everything that is needed to lay it beside a log.
///
/// The matrices act on `ũ`, `x̃` and `ỹ`, the deviations from an operating point in units of a
/// scale: `ỹ = (y − operating point) / scale`, and alike for `u` and `x`.
#[derive(Clone, Debug)]
pub struct LinearModel {
    /// What is modelled, for people.
    pub name: Option<String>,
    /// Input channels.
    pub inputs: Vec<ModelChannel>,
    /// State channels; empty when the states have no names.
    pub states: Vec<ModelChannel>,
    /// Output channels.
    pub outputs: Vec<ModelChannel>,
    /// Matrices and time axis.
    pub system: LinearSystem,
    /// Whether the model is meant to be unstable.
    pub allow_unstable: bool,
}

/// A continuous or discrete state-space model.
#[derive(Clone, Debug)]
pub enum LinearSystem {
    /// Time in seconds.
    Continuous(StateSpace<Continuous>),
    /// Time in samples.
    Discrete(StateSpace<Discrete>),
}

/// A channel of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelChannel {
    /// Name and unit.
    pub channel: Channel,
    /// Operating point and scale, in the unit of the channel.
    pub scale: ChannelScale,
}

impl From<Channel> for ModelChannel {
    /// A channel on which the model acts as it is.
    fn from(channel: Channel) -> Self {
        Self { channel, scale: ChannelScale::default() }
    }
}

impl LinearSystem {
    /// State matrix, input matrix, output matrix and feedthrough.
    #[must_use]
    pub fn matrices(&self) -> [MatRef<'_, f64>; 4] {
        match self {
            Self::Continuous(s) => [s.a(), s.b(), s.c(), s.d()],
            Self::Discrete(s) => [s.a(), s.b(), s.c(), s.d()],
        }
    }

    /// Sample time of a discrete model.
    #[must_use]
    pub fn sample_time(&self) -> Option<SampleTime> {
        match self {
            Self::Continuous(_) => None,
            Self::Discrete(s) => Some(s.domain().ts),
        }
    }

    /// The system at this sample time: a continuous one with its inputs held between samples, a discrete
    /// one as it is.
    ///
    /// # Errors
    ///
    /// Returns an error when the exponential of the state matrix is not finite.
    pub fn sampled(&self, ts: SampleTime) -> Result<StateSpace<Discrete>, ModelError> {
        match self {
            Self::Continuous(system) => system.sample_zoh(ts),
            Self::Discrete(system) => Ok(system.clone()),
        }
    }

    /// The eigenvalue that keeps the model from being stable, if there is one, as real and
    /// imaginary part; of several, the worst.
    ///
    /// # Errors
    ///
    /// Returns an error when the eigenvalues do not converge.
    pub fn unstable_pole(&self) -> Result<Option<(f64, f64)>, ModelError> {
        let poles = match self {
            Self::Continuous(s) => s.poles()?,
            Self::Discrete(s) => s.poles()?,
        };
        // How far outside the stable region: its edge counts as outside.
        let excess = |pole: &(f64, f64)| match self {
            Self::Continuous(_) => pole.0,
            Self::Discrete(_) => pole.0.hypot(pole.1) - 1.0,
        };
        let poles = poles.into_iter().map(|pole| (pole.re, pole.im));
        let unstable = poles.filter(|pole| 0.0 <= excess(pole));
        Ok(unstable.max_by(|a, b| excess(a).total_cmp(&excess(b))))
    }
}

impl LinearModel {
    /// A model whose matrices act on the channels as they are: no operating point, no scales, no
    /// names of states.
    ///
    /// ```
    /// # use faer::mat;
    /// # use fd_model::{Channel, Continuous, StateSpace, file::{LinearModel, LinearSystem}};
    /// let lag = StateSpace::new(mat![[-1.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// let (u, y) = (Channel::new("u", "V"), Channel::new("y", "W"));
    /// let model = LinearModel::new(LinearSystem::Continuous(lag), vec![u], vec![y])?;
    /// assert!(model.to_toml().contains("A = [\n    [-1.0],\n]"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when there is not one channel per input and output, or names are used
    /// twice.
    pub fn new(
        system: LinearSystem,
        inputs: Vec<Channel>,
        outputs: Vec<Channel>,
    ) -> Result<Self, ModelFileError> {
        let with_scales = |c: Vec<Channel>| c.into_iter().map(ModelChannel::from).collect();
        let model = Self {
            name: None,
            inputs: with_scales(inputs),
            states: Vec::new(),
            outputs: with_scales(outputs),
            system,
            allow_unstable: false,
        };
        model.check_channels("model")?;
        Ok(model)
    }

    /// Names and units of the inputs.
    #[must_use]
    pub fn input_channels(&self) -> Vec<Channel> {
        self.inputs.iter().map(|input| input.channel.clone()).collect()
    }

    /// Names and units of the outputs.
    #[must_use]
    pub fn output_channels(&self) -> Vec<Channel> {
        self.outputs.iter().map(|output| output.channel.clone()).collect()
    }

    /// What makes a physical record one that the matrices act on, for
    /// [`Record::scaled`](crate::Record::scaled).
    #[must_use]
    pub fn scaling(&self) -> Scaling {
        let scales = |channels: &[ModelChannel]| channels.iter().map(|c| c.scale).collect();
        Scaling { inputs: scales(&self.inputs), outputs: scales(&self.outputs) }
    }

    pub(super) fn check(&self, file: &str) -> Result<(), ModelFileError> {
        self.check_channels(file)?;
        let wrong = |source| ModelFileError::Model { file: file.to_owned(), source };
        match self.system.unstable_pole().map_err(wrong)? {
            Some((re, im)) if !self.allow_unstable => {
                Err(ModelFileError::Unstable { file: file.to_owned(), re, im })
            }
            _ => Ok(()),
        }
    }

    fn check_channels(&self, file: &str) -> Result<(), ModelFileError> {
        let file = || file.to_owned();
        if self.outputs.is_empty() {
            let source = ModelError::NoOutputs;
            return Err(ModelFileError::Model { file: file(), source });
        }
        let [a, _, _, d] = self.system.matrices();
        let states = if self.states.is_empty() { 0 } else { a.nrows() };
        for (role, channels, expected) in [
            ("input", &self.inputs, d.ncols()),
            ("state", &self.states, states),
            ("output", &self.outputs, d.nrows()),
        ] {
            if channels.len() != expected {
                let found = channels.len();
                return Err(ModelFileError::Count { file: file(), role, expected, found });
            }
            for (i, ModelChannel { channel, scale }) in channels.iter().enumerate() {
                let name = || channel.name.clone();
                if channels[..i].iter().any(|other| other.channel.name == channel.name) {
                    let channel = name();
                    return Err(ModelFileError::DuplicateChannel { file: file(), role, channel });
                }
                let factor = scale.scale.unwrap_or(1.0);
                for (key, expected, found, inside) in [
                    ("operating_point", "finite", scale.offset, scale.offset.is_finite()),
                    ("scale", "finite and not 0", factor, factor.is_normal()),
                ] {
                    if !inside {
                        let (file, channel) = (file(), name());
                        return Err(ModelFileError::Channel {
                            file,
                            role,
                            channel,
                            key,
                            expected,
                            found,
                        });
                    }
                }
            }
        }
        Ok(())
    }
}
