//! A learned bias of any structure, at design time.

use faer::c64;
use fd_ident::{
    IdentError,
    arx::{ArxModel, ArxOrders, Start},
    hammerstein::HammersteinModel,
    scheduled::ScheduledModel,
    subspace::StateSpaceBias,
};
use fd_model::Record;

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

    /// The same model with a bias of zero in every channel that is not `kept`. One state-space model for all channels
    /// cannot be divided: it stays as it is while any channel is kept.
    ///
    /// # Errors
    ///
    /// Never fails for models that were checked when they were made.
    pub(super) fn only(&self, kept: &[bool]) -> Result<Self, IdentError> {
        let silenced = |model: &ArxModel| {
            let per_channel = model.orders().parameters(model.nu());
            let mut theta = model.theta().to_vec();
            for (theta, kept) in theta.chunks_exact_mut(per_channel).zip(kept) {
                if !kept {
                    theta.fill(0.0);
                }
            }
            ArxModel::new(model.orders(), model.nu(), model.residual_len(), theta, model.ts())
        };
        Ok(match self {
            Self::Linear(model) => Self::Linear(silenced(model)?),
            Self::Hammerstein(model) => Self::Hammerstein(HammersteinModel::new(
                model.expansion().clone(),
                silenced(model.linear())?,
            )?),
            Self::Scheduled(model) => {
                let locals = model.locals().iter().map(silenced).collect::<Result<_, _>>()?;
                Self::Scheduled(ScheduledModel::new(model.regions().clone(), locals)?)
            }
            Self::StateSpace(model) if kept.contains(&true) => Self::StateSpace(model.clone()),
            Self::StateSpace(model) => {
                let system = model.system();
                let constant = ArxOrders::new(0, 0, 0).with_offset();
                let (nu, ny, ts) = (system.nu(), system.ny(), system.domain().ts);
                Self::Linear(ArxModel::new(constant, nu, ny, vec![0.0; ny], ts)?)
            }
        })
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
