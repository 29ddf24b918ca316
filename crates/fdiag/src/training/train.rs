//! Learning from healthy logs: the bias first, then what is normal for the rest.

use fd_core::Limits;
use fd_model::Record;

use super::{
    begin::{pre_fitted, settling_samples},
    error::TrainingError,
    examine::inputs_move,
    fault_free::FaultFree,
    healthy::Healthy,
    learn::learn,
    residuals::{means, residual_record},
    trained::Trained,
};
use crate::spec::{NominalPlant, PipelineSpec, StartSpec};

/// Learns the bias and calibrates the detector.
///
/// The residual generator starts from rest at the first sample of each log; the first
/// `settle` samples are not learned from.
///
/// # Errors
///
/// Returns a setting that is beyond the default [`Limits`], or the first step that the model or the logs
/// do not allow.
pub fn train<'a>(
    spec: &PipelineSpec,
    model: impl Into<NominalPlant<'a>>,
    healthy: &[Healthy<'_>],
) -> Result<Trained, TrainingError> {
    train_within(spec, model, healthy, &Limits::default())
}

/// As [`train`], with limits of one's own.
///
/// # Errors
///
/// As [`train`].
pub fn train_within<'a>(
    spec: &PipelineSpec,
    model: impl Into<NominalPlant<'a>>,
    healthy: &[Healthy<'_>],
    limits: &Limits,
) -> Result<Trained, TrainingError> {
    spec.check_limits(limits)?;
    let plant: NominalPlant<'_> = model.into();
    let to_learn = healthy.iter().filter(|log| !log.learn.is_empty());
    let learned_from: Vec<Record> =
        to_learn.clone().map(|log| log.record.slice(log.learn.start, log.learn.end)).collect();
    let design = spec.generator.design(plant.clone(), spec.weighting.as_deref(), &learned_from)?;
    let settle = settling_samples(spec, design.as_ref(), plant.system)?;
    let mut generator = design.build()?;
    let mut records = Vec::new();
    for log in to_learn {
        let residual = residual_record(&mut generator, log.record, settle)?;
        records.push(residual.slice(log.learn.start, log.learn.end));
    }
    if records.is_empty() {
        return Err(TrainingError::NoHealthyLog);
    }
    let complete = |record: &Record| (0..record.len()).any(|k| record.is_complete(k));
    if !records.iter().any(complete) {
        let found = records.iter().map(Record::len).max().unwrap_or(0);
        let what = "learning the bias after the settling time";
        return Err(TrainingError::TooShort { what, needed: settle.saturating_add(1), found });
    }
    let learned = learn(spec, &records)?;
    let filling = if settle == 0 { 0 } else { settle + learned.bias.memory() };
    let fit = pre_fitted(learned.bias.loaded(), &records)?.filling(filling as u64);
    let mut trained = Trained {
        spec: spec.clone(),
        nominal: plant.system.clone(),
        design,
        bias: learned.bias,
        selection: learned.selection,
        compared: learned.compared,
        payments: Vec::new(),
        means: means(&records),
        fit,
        events: learned.events,
        healthy: FaultFree::default(),
        beginnings: FaultFree::default(),
    };
    trained.calibrate(healthy)?;
    if !trained.healthy.is_empty() && trained.spec.start == StartSpec::Fitted {
        trained.apply_where_it_pays(healthy, records.iter().any(inputs_move))?;
    }
    let to_calibrate = healthy.iter().filter(|log| !log.calibrate.is_empty());
    let longest = to_calibrate.map(|log| log.record.len()).max().unwrap_or(0);
    if spec.start == StartSpec::Training && longest > 0 && trained.healthy.is_empty() {
        return Err(TrainingError::NeverOpened { samples: longest });
    }
    Ok(trained)
}

/// Learns from one log and calibrates on others, as the benchmarks do.
///
/// # Errors
///
/// As [`train`].
pub fn train_on<'a>(
    spec: &PipelineSpec,
    model: impl Into<NominalPlant<'a>>,
    training: &Record,
    calibration: &[Record],
) -> Result<Trained, TrainingError> {
    let mut healthy = vec![Healthy::learn(training)];
    healthy.extend(calibration.iter().map(Healthy::calibrate));
    train(spec, model, &healthy)
}
