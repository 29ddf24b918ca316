//! From records to a trained diagnosis and what it says of each later log.

use std::path::PathBuf;

use fd_core::{DynPipeline, Event, stage::Stage};
use fd_model::TimeBaseReport;
use fd_numeric::rms;
use fdiag::Watcher;
use fdiag::{
    spec::{ApplySpec, NominalPlant, PipelineSpec},
    training::{
        Compared, Healthy, Names, Payment, Trace, Trained, TrainingError, examine, inputs_move,
        sensor_sizes, train_within,
    },
};
use serde::{Deserialize, Serialize};

use super::{
    above::AboveMaximum,
    error::LogStudyError,
    healthy::{LogDoubt, Void},
    material::{Material, StudiedLog},
    named::NamedFault,
};

/// The version of the JSON report.
pub const REPORT_VERSION: u32 = 1;

/// The result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogStudy {
    /// Version of this schema.
    pub version: u32,
    /// Name of the model.
    pub model: String,
    /// Output channels.
    pub outputs: Vec<SignalUnit>,
    /// Residual channels.
    pub residuals: Vec<SignalUnit>,
    /// What was chosen.
    pub spec: PipelineSpec,
    /// The learned bias.
    pub bias: BiasSummary,
    /// What speaks against learning from the healthy logs.
    #[serde(default)]
    pub doubts: Vec<LogDoubt>,
    /// Why there is no threshold without compensation to compare with, and hence no alarm without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_compared: Option<String>,
    /// What a threshold above a maximum promises; none when that is a rate, or rare enough.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub above_maximum: Option<AboveMaximum>,
    /// Every log, healthy ones first.
    pub logs: Vec<LogResult>,
}

/// A channel, its unit, and what one in the signals of the report is worth in that unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalUnit {
    /// Name.
    pub name: String,
    /// Unit; `1` when outputs of different units were combined.
    pub unit: String,
    /// Value of one in that unit.
    pub scale: f64,
}

/// The learned bias model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BiasSummary {
    /// Orders.
    pub orders: String,
    /// Parameters of each residual channel.
    pub theta: Vec<f64>,
    /// Magnitudes of the poles of each residual channel.
    pub poles: Vec<Vec<f64>>,
    /// What the order criteria chose, if the order was to be chosen.
    pub selection: Option<String>,
    /// The forms that were compared, the simplest first, if the form was to be chosen.
    #[serde(default)]
    pub compared: Vec<Compared>,
    /// What the bias is worth in each residual channel on held-out healthy samples, and where it is not subtracted.
    #[serde(default)]
    pub payments: Vec<Payment>,
    /// Phases of a recursive training.
    pub events: Vec<Event>,
}

impl BiasSummary {
    fn of(trained: &Trained) -> Result<Self, TrainingError> {
        let bias = trained.bias_model();
        Ok(Self {
            orders: bias.orders(),
            theta: bias.theta(),
            poles: bias.pole_radii()?,
            compared: trained.compared().to_vec(),
            payments: trained.payments().to_vec(),
            selection: trained.order_selection().map(|t| t.verdict().to_string()),
            events: trained.events().to_vec(),
        })
    }
}

/// What became of one log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogResult {
    /// The file.
    pub file: PathBuf,
    /// Whether it is one of the healthy logs.
    pub healthy: bool,
    /// Samples on the even time base.
    pub samples: usize,
    /// The time base of the file.
    pub time_base: TimeBaseReport,
    /// Root mean square of each residual channel before compensation, in scaled units.
    pub rms_primary: Vec<f64>,
    /// The same less a constant, the mean of the healthy residual that the bias was learned from.
    #[serde(default)]
    pub rms_constant: Vec<f64>,
    /// Root mean square of each residual channel after compensation.
    pub rms_compensated: Vec<f64>,
    /// Largest magnitude before and after compensation, all channels.
    pub largest: (f64, f64),
    /// Time in s of the first alarm without and with compensation.
    pub first_alarm_s: (Option<f64>, Option<f64>),
    /// From when to when each alarm with compensation lasted, in s; the last one may end with the log.
    #[serde(default)]
    pub alarms_s: Vec<[f64; 2]>,
    /// Share of samples in alarm without and with compensation.
    pub alarm_share: (f64, f64),
    /// Where the threshold states no rate of false alarms; none when it does throughout.
    #[serde(default)]
    pub void: Option<Void>,
    /// After an alarm that stands at the end of the log: the size that a lasting fault of each
    /// output's sensor would have to explain it, in the unit of the output.
    pub sensor_sizes: Option<Vec<f64>>,
    /// After an alarm: which fault it was ascribed to, when the spec asks for isolation.
    #[serde(default)]
    pub named: Option<NamedFault>,
    /// What happened.
    pub events: Vec<Event>,
    /// Samples refused because they were missing.
    pub refused: usize,
    /// Samples that were judged: complete ones, once the diagnosis has settled.
    #[serde(default)]
    pub judged: usize,
}

/// The signals of the logs, for pictures.
pub struct Traces {
    /// For each log, without and with compensation.
    pub(super) logs: Vec<(Trace, Trace)>,
}

impl Traces {
    /// The signals of the last log, without and with compensation.
    #[must_use]
    pub fn last(&self) -> Option<(&Trace, &Trace)> {
        self.logs.last().map(|(without, with)| (without, with))
    }
}

impl LogStudy {
    /// Learns from the healthy logs and diagnoses all of them. Knows no files but by their names.
    ///
    /// ```no_run
    /// use fdiag::spec::PipelineSpec;
    /// use fdiag_cli::logs::{LogStudy, Request};
    ///
    /// let request = Request {
    ///     model: "model.toml".into(),
    ///     healthy: vec!["healthy.csv".into()],
    ///     logs: vec!["today.csv".into()],
    ///     columns: None,
    ///     spec: PipelineSpec::default(),
    ///     share_to_learn: 0.7,
    ///     limits: fdiag::core::Limits::default(),
    /// };
    /// let (study, _traces) = LogStudy::run(&request.read()?, &())?;
    /// println!("{}", study.headline());
    /// # Ok::<(), fdiag_cli::logs::LogStudyError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when there is no healthy log with inputs that move, or nothing can be learned.
    pub fn run(
        material: &Material,
        watcher: &impl Watcher,
    ) -> Result<(Self, Traces), LogStudyError> {
        let Material { model: file, spec, .. } = material;
        let Some(first) = material.logs.first() else {
            return Err(TrainingError::NoHealthyLog.into());
        };
        let model = file.system.sampled(first.record.ts())?;
        let healthy: Vec<Healthy<'_>> = material
            .logs
            .iter()
            .filter(|log| log.healthy)
            .map(|log| Healthy::split(&log.record, material.share_to_learn))
            .collect();
        let learns = spec.bias.apply != ApplySpec::Never;
        if learns && !healthy.iter().any(|log| inputs_move(log.record)) {
            return Err(LogStudyError::NoExcitation);
        }
        let trained = train_within(
            spec,
            NominalPlant::from(&model).in_units(file.scaling()),
            &healthy,
            &material.limits,
        )?;
        let outputs: Vec<SignalUnit> = file
            .outputs
            .iter()
            .map(|o| SignalUnit {
                name: o.channel.name.clone(),
                unit: o.channel.unit.clone(),
                scale: o.scale.scale.unwrap_or(1.0),
            })
            .collect();
        let mut compensated = trained.compensated()?;
        // The primary residual is only compared with: where its own threshold cannot be had, all else goes on.
        let (mut plain, not_compared) = match trained.uncompensated() {
            Ok(plain) => (plain, None),
            Err(error) => (trained.silent()?, Some(error.to_string())),
        };
        // What learning took says nothing of the logs.
        watcher.begin(material.logs.len() as u64, 0);
        let (mut logs, mut traces) = (Vec::new(), Vec::new());
        let zero = vec![0.0; trained.means().len()];
        for StudiedLog { file: path, record, time_base, healthy } in &material.logs {
            let run = |pipeline: &mut DynPipeline| {
                pipeline.reset();
                Trace::of(pipeline, record).map_err(TrainingError::from)
            };
            let (without, with) = (run(&mut plain)?, run(&mut compensated)?);
            logs.push(LogResult {
                file: path.clone(),
                healthy: *healthy,
                samples: record.len(),
                time_base: time_base.clone(),
                rms_primary: rms_per_channel(&with, &with.residual, &zero),
                rms_constant: rms_per_channel(&with, &with.residual, trained.means()),
                rms_compensated: rms_per_channel(&with, &with.compensated, &zero),
                largest: with.maxima().unwrap_or((f64::NAN, f64::NAN)),
                first_alarm_s: (alarm_time(&without, &with), alarm_time(&with, &with)),
                alarms_s: alarm_intervals(&with),
                alarm_share: (alarm_share(&without, &with), alarm_share(&with, &with)),
                void: Void::of(&with),
                sensor_sizes: sensor_sizes(&trained, &with)?
                    .map(|sizes| sizes.iter().zip(&outputs).map(|(s, o)| s * o.scale).collect()),
                named: NamedFault::of(&with, &spec.isolation, &file.inputs, &file.outputs),
                events: with.events.clone(),
                refused: with.refused,
                judged: with.compensating.iter().filter(|on| **on).count(),
            });
            traces.push((without, with));
            watcher.advance();
        }
        let residuals = residual_units(spec, &outputs, trained.design().residual_len());
        let examination = examine(&trained, &healthy)?;
        let names = Names {
            residuals: residuals.iter().map(|r| (&r.name[..], &r.unit[..], r.scale)).collect(),
            inputs: file.inputs.iter().map(|input| &input.channel.name[..]).collect(),
        };
        let files =
            material.logs.iter().filter(|log| log.healthy).map(|log| Some(log.file.as_path()));
        let mut doubts: Vec<LogDoubt> = Vec::new();
        for (log, found) in
            files.chain([None]).zip(examination.logs.into_iter().chain([examination.together]))
        {
            doubts.extend(found.into_iter().map(|doubt| LogDoubt::new(log, doubt, &names)));
        }
        let study = Self {
            version: REPORT_VERSION,
            model: material.name.clone(),
            residuals,
            outputs,
            spec: spec.clone(),
            bias: BiasSummary::of(&trained)?,
            doubts,
            not_compared,
            above_maximum: AboveMaximum::of(material, &trained),
            logs,
        };
        Ok((study, Traces { logs: traces }))
    }
}

/// Residuals that are compared output by output keep the unit of the output.
fn residual_units(spec: &PipelineSpec, outputs: &[SignalUnit], channels: usize) -> Vec<SignalUnit> {
    let per_output = spec.generator.is_per_output() && spec.weighting.is_none();
    if per_output {
        return outputs.to_vec();
    }
    let name = |i| SignalUnit { name: format!("r{i}"), unit: "1".to_owned(), scale: 1.0 };
    (1..=channels).map(name).collect()
}

/// Root mean square per channel, less a constant in each, over the samples in which the bias was subtracted.
fn rms_per_channel(trace: &Trace, rows: &[f64], constants: &[f64]) -> Vec<f64> {
    let constants = constants.iter().enumerate();
    constants.map(|(at, c)| rms(trace.while_compensating(rows, at).map(|r| r - c))).collect()
}

/// First alarm among the samples in which the bias was subtracted, so that both residuals are
/// judged over the same samples.
fn alarm_time(trace: &Trace, compensated: &Trace) -> Option<f64> {
    (0..trace.len()).find(|&k| compensated.compensating[k] && trace.alarm[k]).map(|k| trace.time[k])
}

/// The times of the first and the last sample of each alarm.
fn alarm_intervals(trace: &Trace) -> Vec<[f64; 2]> {
    let mut intervals: Vec<[f64; 2]> = Vec::new();
    let mut was_on = false;
    for k in 0..trace.len() {
        let is_on = trace.compensating[k] && trace.alarm[k];
        match intervals.last_mut() {
            Some([_, last]) if is_on && was_on => *last = trace.time[k],
            _ if is_on => intervals.push([trace.time[k]; 2]),
            _ => {}
        }
        was_on = is_on;
    }
    intervals
}

fn alarm_share(trace: &Trace, compensated: &Trace) -> f64 {
    let judged = (0..trace.len()).filter(|&k| compensated.compensating[k]);
    let (alarms, count) = judged.fold((0, 0), |(a, n), k| (a + usize::from(trace.alarm[k]), n + 1));
    alarms as f64 / f64::from(count.max(1))
}
