//! A bias model of given structure and orders, from records in one go.

use fd_ident::{
    IdentError,
    arx::{ArxFit, ArxModel, ArxOrders},
    extended::ExtendedLeastSquares,
    hammerstein::HammersteinModel,
    instrumental::InstrumentalVariables,
    prediction_error::{NoiseStructure, PredictionError},
    refine::{Prefilter, Sriv},
    scheduled::ScheduledModel,
};
use fd_model::Record;

use super::{bias::LearnedBias, error::TrainingError, structure::Structure};
use crate::spec::LearningSpec;

/// What is made of a search that has not come to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Search {
    /// Its last model.
    AsFarAsItCame,
    /// None: where it stopped is a matter of rounding, and so of units.
    ToRest,
}

/// A model of given structure and orders from all records in one go.
pub(super) fn fit(
    structure: &Structure,
    learning: &LearningSpec,
    orders: ArxOrders,
    records: &[Record],
    search: Search,
) -> Result<LearnedBias, TrainingError> {
    let equations = |seen: &[Record]| batch(learning, orders, seen, search);
    Ok(match structure {
        Structure::Linear => LearnedBias::Linear(equations(records)?),
        Structure::Hammerstein(expansion) => {
            let linear = equations(&structure.seen(records)?)?;
            LearnedBias::Hammerstein(HammersteinModel::new(expansion.clone(), linear)?)
        }
        Structure::Scheduled(regions) => {
            LearnedBias::Scheduled(ScheduledModel::learn(regions.clone(), records, equations)?)
        }
    })
}

/// Difference equations from records in one go.
fn batch(
    learning: &LearningSpec,
    orders: ArxOrders,
    records: &[Record],
    search: Search,
) -> Result<ArxModel, IdentError> {
    let search = |noise: NoiseStructure, from_rest: bool| {
        let estimator = PredictionError::new(orders, noise);
        let estimator = if from_rest { estimator.from_rest() } else { estimator };
        let estimator = match search {
            Search::AsFarAsItCame => estimator,
            Search::ToRest => estimator.to_rest(),
        };
        Ok(estimator.fit(records)?.model)
    };
    match learning {
        LearningSpec::Batch { prefilter_rad_s } => {
            let mut fit = ArxFit::new(orders);
            if let (Some(omega), Some(first)) = (prefilter_rad_s, records.first()) {
                fit = fit.with_prefilter(Prefilter::low_pass(2, *omega, first.ts())?);
            }
            Ok(fit.fit(records)?.model)
        }
        LearningSpec::Instrumental { instruments } => {
            Ok(InstrumentalVariables::new(orders, *instruments).fit(records)?.model)
        }
        LearningSpec::RefinedInstrumental {} => Ok(Sriv::new(orders).fit(records)?.estimate.model),
        LearningSpec::Extended { nc } => {
            Ok(ExtendedLeastSquares::new(orders, *nc).fit(records)?.model)
        }
        LearningSpec::Armax { nc } => search(NoiseStructure::Armax { nc: *nc }, false),
        LearningSpec::OutputError { from_rest } => search(NoiseStructure::OutputError, *from_rest),
        LearningSpec::BoxJenkins { nc, nd, from_rest } => {
            search(NoiseStructure::BoxJenkins { nc: *nc, nd: *nd }, *from_rest)
        }
        // On-line learning has a way of its own; over records it is least squares.
        LearningSpec::Recursive(_)
        | LearningSpec::RandomWalk(_)
        | LearningSpec::RecursiveExtended { .. }
        | LearningSpec::RecursiveInstrumental(_) => Ok(ArxFit::new(orders).fit(records)?.model),
    }
}
