//! A learned bias of any structure, at design time.

use faer::c64;
use fd_ident::{
    IdentError,
    arx::{ArxModel, ArxOrders, Start},
    hammerstein::HammersteinModel,
    scheduled::ScheduledModel,
    subspace::StateSpaceBias,
};
use fd_model::{Record, SampleTime};

use super::running::RunningBias;

/// A learned bias model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum LearnedBias {
    /// One difference equation per residual channel.
    Linear(ArxModel),
    /// Functions of the inputs before the equations.
    Hammerstein(HammersteinModel),
    /// Local equations, blended over the operating range.
    Scheduled(ScheduledModel),
    /// One state-space model for all channels.
    StateSpace(Box<StateSpaceBias>),
}

impl LearnedBias {
    /// The difference equations, when that is all the model is.
    #[must_use]
    pub fn as_linear(&self) -> Option<&ArxModel> {
        match self {
            Self::Linear(model) => Some(model),
            _ => None,
        }
    }

    /// Number of residual channels.
    #[must_use]
    pub fn residual_len(&self) -> usize {
        match self {
            Self::Linear(model) => model.residual_len(),
            Self::Hammerstein(model) => model.linear().residual_len(),
            Self::Scheduled(model) => model.locals()[0].residual_len(),
            Self::StateSpace(model) => model.system().ny(),
        }
    }

    /// Whether there is a constant term.
    #[must_use]
    pub fn has_constant(&self) -> bool {
        match self {
            Self::Linear(model) => model.orders().offset,
            Self::Hammerstein(model) => model.linear().orders().offset,
            Self::Scheduled(model) => model.locals()[0].orders().offset,
            Self::StateSpace(model) => model.offset().iter().any(|c| c.abs() > 0.0),
        }
    }

    /// The same model with a constant in every channel that has one in `constants`; a state-space model stays as it is
    /// unless all have one.
    ///
    /// # Errors
    ///
    /// Never fails for models that were checked when they were made.
    pub(super) fn but_for(
        &self,
        constants: &[Option<f64>],
        ts: SampleTime,
        nu: usize,
    ) -> Result<Self, IdentError> {
        if let Some(constants) = constants.iter().copied().collect::<Option<Vec<f64>>>() {
            return Self::constant(constants, nu, ts);
        }
        let divided = |model: &ArxModel| {
            let mut theta = Vec::new();
            for (channel, constant) in constants.iter().enumerate() {
                let own = model.channel(channel);
                let (equation, offset) =
                    own.split_at(own.len() - usize::from(model.orders().offset));
                let keeps = f64::from(u8::from(constant.is_none()));
                theta.extend(equation.iter().map(|coefficient| keeps * coefficient));
                theta.push(constant.or(offset.first().copied()).unwrap_or(0.0));
            }
            let orders = model.orders().with_offset();
            ArxModel::new(orders, model.nu(), model.residual_len(), theta, model.ts())
        };
        Ok(match self {
            Self::Linear(model) => Self::Linear(divided(model)?),
            Self::Hammerstein(model) => Self::Hammerstein(HammersteinModel::new(
                model.expansion().clone(),
                divided(model.linear())?,
            )?),
            Self::Scheduled(model) => {
                let locals = model.locals().iter().map(divided).collect::<Result<_, _>>()?;
                Self::Scheduled(ScheduledModel::new(model.regions().clone(), locals)?)
            }
            Self::StateSpace(model) => Self::StateSpace(model.clone()),
        })
    }

    /// A constant in each channel, whatever the inputs do.
    ///
    /// # Errors
    ///
    /// Returns an error when one is not finite.
    pub(super) fn constant(
        constants: Vec<f64>,
        nu: usize,
        ts: SampleTime,
    ) -> Result<Self, IdentError> {
        let orders = ArxOrders::new(0, 0, 0).with_offset();
        Ok(Self::Linear(ArxModel::new(orders, nu, constants.len(), constants, ts)?))
    }

    /// All parameters, for reports.
    #[must_use]
    pub fn theta(&self) -> Vec<f64> {
        match self {
            Self::StateSpace(model) => model.parameters(),
            _ => self.loaded(),
        }
    }

    /// The parameters that the running model loads; none when they are constants of the design.
    pub(super) fn loaded(&self) -> Vec<f64> {
        match self {
            Self::Linear(model) => model.theta().to_vec(),
            Self::Hammerstein(model) => model.linear().theta().to_vec(),
            Self::Scheduled(model) => model.theta(),
            Self::StateSpace(_) => Vec::new(),
        }
    }

    /// Structure and orders in words.
    #[must_use]
    pub fn orders(&self) -> String {
        match self {
            Self::Linear(model) => model.orders().to_string(),
            Self::Hammerstein(model) => {
                let functions = model.expansion().expanded_len();
                format!("{} over {functions} input functions", model.linear().orders())
            }
            Self::Scheduled(model) => {
                let (own, all) = (model.learned().iter().filter(|l| **l).count(), model.regions());
                format!("{} in {} regions, {own} learned", model.locals()[0].orders(), all.len())
            }
            Self::StateSpace(model) => format!("{} states", model.system().nx()),
        }
    }

    /// Samples that the model looks back on: how long its memory takes to fill from measurements.
    #[must_use]
    pub fn memory(&self) -> usize {
        match self {
            Self::Linear(model) => model.orders().lag(),
            Self::Hammerstein(model) => model.linear().orders().lag(),
            Self::Scheduled(model) => model.locals()[0].orders().lag(),
            // The observer is not deadbeat; each state is given a few samples.
            Self::StateSpace(model) => 10 * model.system().nx(),
        }
    }

    /// Magnitudes of the poles of each residual channel, all regions together.
    ///
    /// # Errors
    ///
    /// Returns an error when the eigenvalues do not converge.
    pub fn pole_radii(&self) -> Result<Vec<Vec<f64>>, IdentError> {
        let of = |models: &[&ArxModel], channel: usize| -> Result<Vec<f64>, IdentError> {
            let mut radii = Vec::new();
            for model in models {
                radii.extend(model.poles(channel)?.iter().map(|pole| pole.norm()));
            }
            Ok(radii)
        };
        let channels = 0..self.residual_len();
        match self {
            Self::Linear(model) => channels.map(|i| of(&[model], i)).collect(),
            Self::Hammerstein(model) => channels.map(|i| of(&[model.linear()], i)).collect(),
            Self::Scheduled(model) => {
                let locals: Vec<&ArxModel> = model.locals().iter().collect();
                channels.map(|i| of(&locals, i)).collect()
            }
            Self::StateSpace(model) => {
                let poles = model.system().poles()?;
                let radii: Vec<f64> = poles.iter().map(|pole| pole.norm()).collect();
                Ok(channels.map(|_| radii.clone()).collect())
            }
        }
    }

    /// Response of one residual channel to one input at a frequency in rad/s; `None` for a
    /// nonlinear model.
    #[must_use]
    pub fn frequency_response(&self, channel: usize, input: usize, omega: f64) -> Option<c64> {
        match self {
            Self::Linear(model) => Some(model.frequency_response(channel, input, omega)),
            Self::StateSpace(model) => {
                model.system().frequency_response(omega).ok().map(|g| g[(channel, input)])
            }
            Self::Hammerstein(_) | Self::Scheduled(_) => None,
        }
    }

    /// Simulates a residual record from rest and its inputs alone, row-major.
    ///
    /// # Errors
    ///
    /// Returns an error when the record has other channels than the model.
    pub fn simulate_record(&self, record: &Record) -> Result<Vec<f64>, IdentError> {
        match self {
            Self::Linear(model) => model.simulate_record(record, Start::Rest),
            Self::Hammerstein(model) => model.simulate_record(record, Start::Rest),
            Self::Scheduled(model) => model.simulate_record(record),
            Self::StateSpace(model) => model.simulate_record(record),
        }
    }

    /// Moves the model to run time.
    ///
    /// # Errors
    ///
    /// Never fails for models that were checked when they were made.
    pub fn freeze(&self) -> Result<RunningBias, IdentError> {
        Ok(match self {
            Self::Linear(model) => RunningBias::Linear(model.freeze()?),
            Self::Hammerstein(model) => RunningBias::Hammerstein(model.freeze()?),
            Self::Scheduled(model) => RunningBias::Scheduled(model.freeze()?),
            Self::StateSpace(model) => RunningBias::StateSpace(model.freeze()?),
        })
    }
}
