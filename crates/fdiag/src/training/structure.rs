//! The shape of a bias model before it has parameters: what its identifiers and models need.

use fd_compensate::residual_compensation::FixedParameters;
use fd_core::stage::Identifier;
use fd_ident::{
    arx::{ArxModel, ArxOrders, RecursiveArx},
    extended::RecursiveArmax,
    hammerstein::{Expanded, Expansion, HammersteinModel},
    instrumental::RecursiveIv,
    random_walk::KalmanRls,
    rls::{RlsDesign, RlsKernel, UdRls},
    scheduled::{RecursiveScheduled, Regions, ScheduledModel},
};
use fd_model::{Record, SampleTime};

use super::{bias::LearnedBias, error::TrainingError};
use crate::spec::{LearningSpec, StructureSpec};

/// A boxed identifier.
pub(super) type DynIdentifier = Box<dyn Identifier>;

/// What training data have to say about the structure, for difference equations.
#[derive(Clone, Debug)]
pub(super) enum Structure {
    Linear,
    Hammerstein(Expansion),
    Scheduled(Regions),
}

/// Sizes of a bias model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    pub orders: ArxOrders,
    pub nu: usize,
    pub channels: usize,
}

impl Structure {
    /// The structure of a spec, with ranges, knots and centres from the data; `None` for
    /// structures that are no difference equations.
    pub(super) fn of(
        spec: &StructureSpec,
        records: &[Record],
    ) -> Result<Option<Self>, TrainingError> {
        Ok(Some(match spec {
            StructureSpec::Linear => Self::Linear,
            StructureSpec::Hammerstein { basis } => {
                Self::Hammerstein(Expansion::from_training(*basis, records)?)
            }
            StructureSpec::Scheduled { input, time_constant_s, regions, centres } => {
                let samples = match records.first() {
                    Some(first) => time_constant_s / first.ts().seconds(),
                    None => return Err(TrainingError::NoHealthyLog),
                };
                Self::Scheduled(match centres {
                    Some(centres) => Regions::new(*input, samples, centres.clone())?,
                    None => Regions::from_training(*input, samples, *regions, records)?,
                })
            }
            StructureSpec::StateSpace { .. } => return Ok(None),
        }))
    }

    /// The structure of a learned model.
    pub(super) fn of_learned(bias: &LearnedBias) -> Option<(Self, ArxOrders)> {
        Some(match bias {
            LearnedBias::Linear(model) => (Self::Linear, model.orders()),
            LearnedBias::Hammerstein(model) => {
                (Self::Hammerstein(model.expansion().clone()), model.linear().orders())
            }
            LearnedBias::Scheduled(model) => {
                (Self::Scheduled(model.regions().clone()), model.locals()[0].orders())
            }
            LearnedBias::StateSpace(_) => return None,
        })
    }

    /// Number of inputs of the equations.
    fn equation_inputs(&self, nu: usize) -> usize {
        match self {
            Self::Hammerstein(expansion) => expansion.expanded_len(),
            Self::Linear | Self::Scheduled(_) => nu,
        }
    }

    /// Records as the equations see them.
    pub(super) fn seen(&self, records: &[Record]) -> Result<Vec<Record>, TrainingError> {
        Ok(match self {
            Self::Hammerstein(expansion) => {
                records.iter().map(|record| expansion.expand(record)).collect::<Result<_, _>>()?
            }
            Self::Linear | Self::Scheduled(_) => records.to_vec(),
        })
    }

    /// The model with the given parameters, in the order of the identifiers.
    pub(super) fn with_parameters(
        &self,
        sizes: Sizes,
        theta: &[f64],
        ts: SampleTime,
    ) -> Result<LearnedBias, TrainingError> {
        let Sizes { orders, nu, channels } = sizes;
        let inputs = self.equation_inputs(nu);
        let arx = |theta: Vec<f64>| ArxModel::new(orders, inputs, channels, theta, ts);
        Ok(match self {
            Self::Linear => LearnedBias::Linear(arx(theta.to_vec())?),
            Self::Hammerstein(expansion) => LearnedBias::Hammerstein(HammersteinModel::new(
                expansion.clone(),
                arx(theta.to_vec())?,
            )?),
            Self::Scheduled(regions) => {
                let n = orders.parameters(inputs);
                let local = |region: usize| {
                    let own = theta.chunks(n).skip(region).step_by(regions.len());
                    arx(own.flatten().copied().collect())
                };
                let locals = (0..regions.len()).map(local).collect::<Result<_, _>>()?;
                LearnedBias::Scheduled(ScheduledModel::new(regions.clone(), locals)?)
            }
        })
    }

    /// The identifier of a spec, for training on line and for re-training; recursive least
    /// squares stands in where learning is not on line.
    pub(super) fn identifier(
        &self,
        learning: &LearningSpec,
        sizes: Sizes,
    ) -> Result<DynIdentifier, TrainingError> {
        let n = sizes.orders.parameters(self.equation_inputs(sizes.nu));
        match learning {
            LearningSpec::RandomWalk(design) => {
                self.with_kernel(sizes, KalmanRls::<f64>::new(n, design)?)
            }
            LearningSpec::RecursiveExtended { nc, rls } => {
                let kernel = UdRls::<f64>::new(n + nc, rls)?;
                self.before(sizes, "recursive-extended", |inputs| {
                    RecursiveArmax::new(sizes.orders, *nc, inputs, sizes.channels, kernel)
                        .map_err(TrainingError::from)
                })
            }
            LearningSpec::RecursiveInstrumental(design) => {
                self.before(sizes, "recursive-instrumental", |inputs| {
                    RecursiveIv::<f64>::new(sizes.orders, inputs, sizes.channels, design)
                        .map_err(TrainingError::from)
                })
            }
            LearningSpec::Recursive(rls) => self.with_kernel(sizes, UdRls::<f64>::new(n, rls)?),
            _ => self.with_kernel(sizes, UdRls::<f64>::new(n, &RlsDesign::default())?),
        }
    }

    /// Recursive equations on any kernel.
    fn with_kernel(
        &self,
        sizes: Sizes,
        kernel: impl RlsKernel<f64> + 'static,
    ) -> Result<DynIdentifier, TrainingError> {
        let Sizes { orders, nu, channels } = sizes;
        if let Self::Scheduled(regions) = self {
            return Ok(Box::new(RecursiveScheduled::new(regions, orders, nu, channels, kernel)?));
        }
        self.before(sizes, "recursive", |inputs| {
            RecursiveArx::new(orders, inputs, channels, kernel).map_err(TrainingError::from)
        })
    }

    /// An identifier that takes the inputs of the equations, with what is before them.
    fn before<I: Identifier + 'static>(
        &self,
        sizes: Sizes,
        learning: &'static str,
        make: impl FnOnce(usize) -> Result<I, TrainingError>,
    ) -> Result<DynIdentifier, TrainingError> {
        let identifier = make(self.equation_inputs(sizes.nu))?;
        Ok(match self {
            Self::Linear => Box::new(identifier),
            Self::Hammerstein(expansion) => Box::new(Expanded::new(expansion, identifier)?),
            Self::Scheduled(_) => {
                return Err(TrainingError::NotTogether { learning, structure: "scheduled" });
            }
        })
    }
}

/// The identifier that stands by for re-training a learned bias.
pub(super) fn stand_by(
    bias: &LearnedBias,
    learning: &LearningSpec,
    nu: usize,
) -> Result<DynIdentifier, TrainingError> {
    let channels = bias.residual_len();
    match Structure::of_learned(bias) {
        Some((structure, orders)) => structure.identifier(learning, Sizes { orders, nu, channels }),
        // Nothing to load, hence nothing to learn: training only finds the state again.
        None => Ok(Box::new(FixedParameters::<f64>::new(nu, channels, &[]))),
    }
}
