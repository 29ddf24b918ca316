//! What every unit is watched by: a model, a spec, and healthy samples to learn from.

use fd_core::{DynPipeline, Limits};
use fd_model::{
    ChannelScale, Discrete, ModelError, Record, RecordError, SampleTime, StateSpace,
    file::LinearModel,
};
use fdiag::{
    spec::{ApplySpec, FaultPlace, NominalPlant, PipelineSpec},
    training::{Healthy, LONGEST_GAP, Trained, TrainingError, inputs_move, train_within},
};
use thiserror::Error;

use crate::{
    alarms::{AlarmSettings, SettingsError},
    clock::ClockPlan,
    learning::Learning,
    state::Identity,
};

/// Distance from a grid time that counts as none, in steps, as in logs.
const TOLERANCE: f64 = 1e-3;

/// What is wanted of a monitor.
///
/// ```
/// # use fd_model::{SampleTime, file::LinearModel};
/// use fd_watch::{Learning, Request};
///
/// # let text = r#"
/// # version = 1
/// # kind = "state-space"
/// # sample_time = 0.1
/// # inputs = [{ name = "u" }]
/// # outputs = [{ name = "y" }]
/// # matrices = { A = [[0.9]], B = [[0.1]], C = [[1.0]], D = [[0.0]] }
/// # "#;
/// let model = LinearModel::parse("model.toml", text)?;
/// let plan = Request::new(model, Learning::Stream { samples: 600 }).plan()?;
/// assert_eq!(plan.sample_time(), 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Request {
    /// The nominal plant.
    pub model: LinearModel,
    /// The diagnosis.
    pub spec: PipelineSpec,
    /// Where units learn what is normal.
    pub learning: Learning,
    /// Share of healthy samples, from their start, that the bias is learned from; the threshold is taken
    /// from the rest.
    pub share_to_learn: f64,
    /// Time between samples; without it that of the model, or else of the first log.
    pub sample_time: Option<SampleTime>,
    /// Longest distance of samples that is bridged, in s; without it five samples.
    pub longest_gap: Option<f64>,
    /// Most units; samples of further ones are refused.
    pub most_units: usize,
    /// Whether somebody is asked before a unit is trained again, see [`Monitor::answer`](crate::Monitor::answer).
    pub ask: bool,
    /// How alarms are raised, held and repeated.
    pub alarms: AlarmSettings,
    /// How large numbers of the spec and the learned stretch may be.
    pub limits: Limits,
}

/// A monitor cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// Nothing says how far samples are apart.
    #[error(
        "the model is continuous and there is no healthy log: state the sample time, in seconds"
    )]
    NoSampleTime,
    /// Two things say it differently.
    #[error("the sample time of {what} is {found} s, expected {expected} s")]
    SampleTime {
        /// What differs.
        what: &'static str,
        /// What was said first.
        expected: f64,
        /// What it says.
        found: f64,
    },
    /// A number is out of its range.
    #[error("{what} must be {expected}, got {found}")]
    Range {
        /// Which.
        what: &'static str,
        /// The range in words.
        expected: &'static str,
        /// The number.
        found: f64,
    },
    /// Nothing can be learned from inputs that stand still.
    #[error("no input moves in the healthy samples, so the bias that it causes cannot be learned")]
    NoExcitation,
    /// The model cannot be sampled.
    #[error("model: {0}")]
    Model(#[from] ModelError),
    /// A log does not fit the model.
    #[error("healthy log: {0}")]
    Record(#[from] RecordError),
    /// Nothing can be learned, or the spec asks for what cannot be.
    #[error(transparent)]
    Training(#[from] TrainingError),
    /// Settings of the alarms cannot be.
    #[error("alarms: {0}")]
    Alarms(#[from] SettingsError),
}

/// What every unit is watched by.
#[derive(Debug)]
pub struct Plan {
    model: LinearModel,
    spec: PipelineSpec,
    plant: StateSpace<Discrete>,
    step: SampleTime,
    scales: Vec<ChannelScale>,
    share_to_learn: f64,
    limits: Limits,
    /// Of what was learned from logs.
    trained: Option<Trained>,
    pub(crate) to_learn: u64,
    pub(crate) clock: ClockPlan,
    pub(crate) places: Vec<FaultPlace>,
    pub(crate) rule: String,
    pub(crate) most_units: usize,
    pub(crate) alarms: AlarmSettings,
    pub(crate) identity: Identity,
}

impl Request {
    /// A monitor with the default spec.
    #[must_use]
    pub fn new(model: LinearModel, learning: Learning) -> Self {
        Self {
            model,
            spec: PipelineSpec::default(),
            learning,
            share_to_learn: 0.7,
            sample_time: None,
            longest_gap: None,
            most_units: 100_000,
            ask: false,
            alarms: AlarmSettings::default(),
            limits: Limits::default(),
        }
    }

    /// Learns from the logs, if there are any, and checks everything that can be checked without samples.
    ///
    /// # Errors
    ///
    /// Returns what is missing, contradicts itself, or cannot be learned.
    pub fn plan(self) -> Result<Plan, PlanError> {
        let Self { model, mut spec, learning, share_to_learn, .. } = self;
        spec.check_limits(&self.limits).map_err(TrainingError::from)?;
        self.alarms.check()?;
        if !(0.0 < share_to_learn && share_to_learn < 1.0) {
            let expected = "between 0 and 1, both excluded";
            return Err(PlanError::Range {
                what: "the share to learn",
                expected,
                found: share_to_learn,
            });
        }
        let logs = if let Learning::Logs(logs) = &learning { &logs[..] } else { &[] };
        let stated = self.sample_time.or(model.system.sample_time());
        let step = stated.or(logs.first().map(Record::ts)).ok_or(PlanError::NoSampleTime)?;
        let same = |what, ts: SampleTime| {
            let (expected, found) = (step.seconds(), ts.seconds());
            let close = (found - expected).abs() <= 1e-6 * expected;
            if close { Ok(()) } else { Err(PlanError::SampleTime { what, expected, found }) }
        };
        model.system.sample_time().map_or(Ok(()), |ts| same("the model", ts))?;
        logs.iter().try_for_each(|log| same("a healthy log", log.ts()))?;
        let seconds = step.seconds();
        let gap = self.longest_gap.unwrap_or(LONGEST_GAP as f64 * seconds);
        if !(seconds <= gap && gap.is_finite()) {
            let expected = "at least the sample time, in seconds";
            return Err(PlanError::Range { what: "the longest gap", expected, found: gap });
        }
        let to_learn = match &learning {
            Learning::Logs(_) => 0,
            Learning::Stream { samples } => {
                let resource = fd_core::Resource::Samples;
                let checked = self.limits.check(resource, "samples to learn from", *samples as f64);
                checked.map_err(TrainingError::from)?;
                if *samples == 0 {
                    let what = "the number of samples to learn from";
                    return Err(PlanError::Range { what, expected: "at least 1", found: 0.0 });
                }
                *samples
            }
        };
        let identity = Identity::of(&model, &spec, &learning, share_to_learn, step, gap);
        // Not a part of the identity: somebody may choose to be asked, or not any more, in the midst of it.
        spec.compensation.ask |= self.ask;
        let scaling = model.scaling();
        let mut plan = Plan {
            plant: model.system.sampled(step)?,
            step,
            scales: scaling.inputs.iter().chain(&scaling.outputs).copied().collect(),
            share_to_learn,
            limits: self.limits,
            trained: None,
            to_learn,
            clock: ClockPlan {
                step: seconds,
                longest_gap: gap + TOLERANCE * seconds,
                tolerance: TOLERANCE,
                inputs: model.inputs.len(),
            },
            places: spec.isolation.places(&model.inputs, &model.outputs).unwrap_or_default(),
            rule: spec.detector.kind(),
            most_units: self.most_units,
            alarms: self.alarms,
            identity,
            model,
            spec,
        };
        if let Learning::Logs(logs) = learning {
            let scaled: Result<Vec<Record>, RecordError> =
                logs.iter().map(|log| log.scaled(&scaling)).collect();
            plan.trained = Some(plan.learn(&scaled?)?);
        }
        Ok(plan)
    }
}

impl Plan {
    /// Time between samples, in s.
    #[must_use]
    pub fn sample_time(&self) -> f64 {
        self.step.seconds()
    }

    /// The nominal plant.
    #[must_use]
    pub fn model(&self) -> &LinearModel {
        &self.model
    }

    /// Inputs and outputs of a sample.
    pub(crate) fn channels(&self) -> usize {
        self.scales.len()
    }

    /// A sample in the units of the model.
    pub(crate) fn scale(&self, values: &[f64], scaled: &mut Vec<f64>) {
        scaled.clear();
        scaled.extend(values.iter().zip(&self.scales).map(|(v, scale)| scale.scaled(*v)));
    }

    /// A pipeline of what was learned from logs; none when every unit learns for itself.
    pub(crate) fn common(&self) -> Result<Option<DynPipeline>, TrainingError> {
        self.trained.as_ref().map(Trained::compensated).transpose()
    }

    /// A pipeline learned from rows of scaled samples of one unit.
    pub(crate) fn own(&self, rows: &[f64]) -> Result<DynPipeline, PlanError> {
        let (inputs, outputs) = (self.model.input_channels(), self.model.output_channels());
        let nu = inputs.len();
        let rows = rows.chunks_exact(self.channels()).map(|row| row.split_at(nu));
        let record = Record::from_rows(inputs, outputs, rows, self.step)?;
        Ok(self.learn(&[record])?.compensated()?)
    }

    fn learn(&self, records: &[Record]) -> Result<Trained, PlanError> {
        if self.spec.bias.apply != ApplySpec::Never && !records.iter().any(inputs_move) {
            return Err(PlanError::NoExcitation);
        }
        let split = |record| Healthy::split(record, self.share_to_learn);
        let healthy: Vec<Healthy<'_>> = records.iter().map(split).collect();
        let plant = NominalPlant::from(&self.plant).in_units(self.model.scaling());
        Ok(train_within(&self.spec, plant, &healthy, &self.limits)?)
    }
}
