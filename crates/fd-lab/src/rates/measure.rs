//! From plants to the shares of healthy runs that alarm.

use fd_compensate::calibrate::Beyond;
use fd_core::stage::Stage;
use fd_model::Record;
use fd_numeric::rms;
use fdiag::{
    spec::{NominalPlant, PipelineSpec, StartSpec},
    training::{Healthy, Trace, Trained, TrainingError, train},
};

use super::detectors::Stated;
use crate::compare::{Ask, CompareConfig, CompareError, OwnPlants, Plants, Runs, Share};

/// What is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Plants, each with logs of its own.
    pub plants: u64,
    /// Healthy logs that a diagnosis is trained on.
    pub healthy: usize,
    /// Healthy runs per plant that are counted.
    pub fresh: usize,
    /// Share of each healthy log, from its start, that the bias is learned from.
    pub learn_share: f64,
    /// Settling time in s; none is what the model needs.
    pub settle_s: Option<f64>,
    /// Relative change of the parameters at which learning on line ends; none is that of the default.
    pub tolerance: Option<f64>,
    /// Whether a diagnosis begins with the fitted bias or in training.
    pub start: StartSpec,
}

/// How often a detector alarms on healthy runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Rate {
    /// The detector.
    pub detector: &'static str,
    /// Of all plants together, with an interval that knows that runs of one plant are alike.
    pub share: Share,
    /// Alarms and runs of each plant.
    pub plants: Vec<(u64, u64)>,
    /// Why there is none of a plant.
    pub refused: Vec<String>,
}

/// How much of the residual of fresh healthy runs compensation leaves on one plant.
#[derive(Clone, Debug, PartialEq)]
pub struct Left {
    /// Structure and orders of the bias model.
    pub bias: String,
    /// Of its rms, geometric mean over the channels.
    pub of_all: f64,
    /// Of its rms about the mean of the residuals that the bias was learned from, which a constant alone leaves.
    pub of_constant: f64,
}

/// What was measured of some plants of a kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Detector by detector.
    pub rates: Vec<Rate>,
    /// Plant by plant, of those on which training was not refused.
    pub left: Vec<Left>,
}

/// Trains on healthy logs of each plant of the first scenario, which is one of one's own, and counts the fresh healthy
/// runs in which each detector alarms. The residual is that of the first generator of the configuration, all other
/// settings are as they come.
///
/// # Errors
///
/// Returns an error when there is no such plant, or it cannot be run. A detector that cannot be calibrated is in its
/// [`Rate`].
pub fn measure(
    config: &CompareConfig,
    plan: &Plan,
    detectors: &[Stated],
) -> Result<Measured, CompareError> {
    let setting = |setting: &str, expected| CompareError::Setting {
        setting: setting.to_owned(),
        expected,
        found: "none".to_owned(),
    };
    let own = config.scenarios.first().and_then(|scenario| scenario.own.as_ref());
    let own = own.ok_or_else(|| setting("scenarios.own", "a plant of one's own"))?;
    let generator =
        config.generators.first().ok_or_else(|| setting("generators", "at least one"))?;
    let plants = OwnPlants::new(config, own)?;
    let rates = detectors.iter().map(Rate::of).collect();
    let mut measured = Measured { rates, left: Vec::new() };
    for seed in (config.first_seed..).take(usize::try_from(plan.plants).unwrap_or(usize::MAX)) {
        let fresh_runs = (plan.healthy + plan.fresh) as u64;
        let runs = plants.runs(Ask { seed, fresh_runs, tested: false })?;
        let mut spec = PipelineSpec {
            generator: generator.spec.clone(),
            start: plan.start,
            settle_s: plan.settle_s,
            ..PipelineSpec::default()
        };
        if let Some(tolerance) = plan.tolerance {
            spec.compensation.convergence.tolerance = tolerance;
        }
        // So many logs as users have do not resolve a rate. The interval of the threshold is of no interest here.
        (spec.calibration.beyond, spec.calibration.records) = (Beyond::Extrapolate, 1);
        count(&runs, &spec, plan, detectors, &mut measured);
    }
    for rate in &mut measured.rates {
        rate.share = Share::clustered(&rate.plants);
    }
    Ok(measured)
}

/// Adds the runs of one plant.
fn count(
    runs: &Runs,
    spec: &PipelineSpec,
    plan: &Plan,
    detectors: &[Stated],
    measured: &mut Measured,
) {
    let (learned, fresh) = runs.healthy.split_at(plan.healthy.min(runs.healthy.len()));
    let healthy: Vec<Healthy<'_>> =
        learned.iter().map(|log| Healthy::split(log, plan.learn_share)).collect();
    let model = NominalPlant::from(&runs.model).in_units(runs.scaling.clone());
    let mut trained = train(spec, model, &healthy);
    if let Ok(trained) = &trained {
        measured.left.extend(Left::of(trained, fresh).ok());
    }
    for (Stated { spec, .. }, rate) in detectors.iter().zip(&mut measured.rates) {
        let alarms = match &mut trained {
            Ok(trained) => alarms(trained.judge_by(spec.clone()), fresh),
            Err(error) => Err(error.clone()),
        };
        match alarms {
            Ok(alarms) => rate.plants.push((alarms, fresh.len() as u64)),
            Err(error) => rate.refused.push(error.to_string()),
        }
    }
}

/// The runs in which an alarm is raised.
fn alarms(trained: &Trained, fresh: &[Record]) -> Result<u64, TrainingError> {
    let mut pipeline = trained.compensated()?;
    let mut alarms = 0;
    for run in fresh {
        pipeline.reset();
        alarms += u64::from(Trace::of(&mut pipeline, run)?.first_alarm(0).is_some());
    }
    Ok(alarms)
}

impl Left {
    fn of(trained: &Trained, fresh: &[Record]) -> Result<Self, TrainingError> {
        let mut pipeline = trained.silent()?;
        let mut traces = Vec::new();
        for run in fresh {
            pipeline.reset();
            traces.push(Trace::of(&mut pipeline, run)?);
        }
        let left = |of: fn(&Trace) -> &[f64], channel: usize, constant: f64| {
            let judged = traces.iter().flat_map(|t| t.while_compensating(of(t), channel));
            rms(judged.map(|r| r - constant))
        };
        let means = trained.means();
        let ratio = |channel, constant| {
            left(|t| &t.compensated, channel, 0.0) / left(|t| &t.residual, channel, constant)
        };
        let mean = |constants: &dyn Fn(usize) -> f64| {
            let ratios = (0..means.len()).map(|channel| ratio(channel, constants(channel)));
            (ratios.map(f64::ln).sum::<f64>() / means.len() as f64).exp()
        };
        Ok(Self {
            bias: trained.bias_model().orders(),
            of_all: mean(&|_| 0.0),
            of_constant: mean(&|channel| means[channel]),
        })
    }
}

impl Rate {
    fn of(detector: &Stated) -> Self {
        Self {
            detector: detector.name,
            share: Share::new(0, 0),
            plants: Vec::new(),
            refused: Vec::new(),
        }
    }
}
