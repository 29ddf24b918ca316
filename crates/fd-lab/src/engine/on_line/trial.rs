//! One engine on line.

use fd_core::{DynPipeline, EventKind, stage::Stage};
use fd_model::Record;
use fd_numeric::rms;
use fdiag::{
    spec::{LearningSpec, PipelineSpec},
    training::{Trace, Trained, TrainingError, residual_record},
};
use serde::{Deserialize, Serialize};

use super::config::TrainingFault;
use crate::engine::{
    benchmark::{Benchmark, Case, Draw},
    error::EngineStudyError,
    logs::Logs,
    pair::Pair,
    watch::Watch,
};

/// What came out on line for one engine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OnLine {
    /// Time in s from the first sample to the opening of the switch; none if it did not open.
    pub opened_s: Option<f64>,
    /// Why it did not open, or why what was learned cannot be used.
    pub refused: Option<String>,
    /// What came after it.
    pub open: Option<Opened>,
}

/// What came after the opening.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Opened {
    /// Largest fault-free residual over the calibration runs.
    pub fault_free: Pair,
    /// Share of fault-free test runs with an alarm.
    pub false_alarms: Pair,
    /// Smallest detectable size of each faulty sensor with the bias that was learned on line.
    pub smallest: Vec<f64>,
    /// One entry per fault in training.
    pub in_training: Vec<InTraining>,
    /// The engine stays as it is.
    pub healthy: Afterwards,
    /// The same with an input that jumps further than the threshold was set on.
    #[serde(default)]
    pub jumps: Afterwards,
    /// One entry per fault of the training, when it begins after the opening.
    #[serde(default)]
    pub faults: Vec<Afterwards>,
    /// The incipient fault of the benchmark begins.
    pub incipient: Afterwards,
    /// The engine becomes another one.
    pub drift: Option<Drift>,
}

/// What a fault did that began half way through the training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InTraining {
    /// Time in s from its beginning to the report of a hard fault.
    pub reported_s: Option<f64>,
    /// Whether the switch opened although it was there.
    pub opened: bool,
    /// Whether there was an alarm in the `lead_s` after that.
    pub alarm: bool,
    /// Mean of `r*` over that time relative to what the fault leaves in the residual in the end: 1 shows all of
    /// it, 0 hides it.
    pub shown: Option<f64>,
}

/// What was said after the opening, from the sample on in which something begins, or would.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Afterwards {
    /// Time in s until the plant was said to have changed.
    pub changed_s: Option<f64>,
    /// Time in s until the first alarm.
    pub alarm_s: Option<f64>,
    /// Time in s until the first alarm while the threshold was not said to be void.
    #[serde(default)]
    pub stated_alarm_s: Option<f64>,
    /// Share of the samples for which the threshold was said to be void.
    #[serde(default)]
    pub void: f64,
}

/// What became of an engine that drifted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    /// What was said of it.
    pub said: Afterwards,
    /// Time in s from the beginning of the drift until the switch was open again for good.
    pub learned_s: Option<f64>,
    /// Root mean square of `r*` before the drift.
    pub before: f64,
    /// The same at the end of the run with the parameters that were learned before the drift.
    pub old: f64,
    /// The same with those that were learned again.
    pub new: f64,
}

/// The same pipeline for every run, always from its first sample.
struct Line<'a> {
    trained: &'a Trained,
    pipeline: DynPipeline,
    ts: f64,
    /// The sample of the opening without faults.
    opened: usize,
    /// The sample in which something begins.
    begins: usize,
}

impl Benchmark {
    /// Learns on line; `None` when that is not asked for or the engine is nonlinear.
    pub(in crate::engine) fn on_line(
        &self,
        case: &mut Case,
        logs: &Logs,
    ) -> Result<Option<OnLine>, EngineStudyError> {
        let config = &self.config().on_line;
        if !config.run || case.plant.is_none() {
            return Ok(None);
        }
        let longest = self.samples(config.longest_s);
        let (lead, after) = (self.samples(config.lead_s), self.samples(config.after_s));
        let whole = self.draw_long(case, longest + lead + after)?;
        let training = self.run(&case.training, &Self::shorter(&whole, longest)?, &[])?;
        let mut spec = PipelineSpec {
            compensation: config.compensation.clone(),
            detector: config.detector.clone(),
            calibration: config.calibration.clone(),
            ..self.config().pipeline.clone()
        };
        spec.bias.learning = LearningSpec::Recursive(config.learning);
        let trained = match Self::train(&spec, case, &training, &logs.calibration) {
            Ok(trained) => trained,
            Err(EngineStudyError::Training(
                error @ (TrainingError::NotConverged { .. } | TrainingError::UnstableBias { .. }),
            )) => {
                return Ok(Some(OnLine {
                    opened_s: None,
                    refused: Some(error.to_string()),
                    open: None,
                }));
            }
            Err(error) => return Err(error),
        };
        let frozen = trained.events().iter().rev().find(|event| event.kind == EventKind::Frozen);
        let Some(opened) = frozen.and_then(|event| usize::try_from(event.k).ok()) else {
            return Ok(None);
        };
        let ts = self.ts().seconds();
        let line = Line {
            pipeline: trained.learning()?,
            trained: &trained,
            ts,
            opened,
            begins: opened + lead,
        };
        let draw = Self::shorter(&whole, opened + lead + after)?;
        let open = self.opened(case, logs, line, &draw)?;
        Ok(Some(OnLine { opened_s: Some(opened as f64 * ts), refused: None, open: Some(open) }))
    }

    fn opened(
        &self,
        case: &mut Case,
        logs: &Logs,
        mut line: Line<'_>,
        draw: &Draw,
    ) -> Result<Opened, EngineStudyError> {
        let trained = line.trained;
        let tests = self.tests(trained, &logs.tests)?;
        let (primary, compensated) = trained.calibration();
        let mut plain = Watch::new(trained, primary)?;
        let mut watch = Watch::new(trained, compensated)?;
        let false_alarms = Pair {
            primary: plain.false_alarms(&tests.primary)?,
            compensated: watch.false_alarms(&tests.compensated)?,
        };
        let size = self.config().faults.size;
        let channels = self.fault_channels()?;
        let mut smallest = Vec::new();
        for &channel in &channels {
            let (_, phi) = self.unit_fault_response(trained, channel)?;
            smallest.push(watch.find(&tests.compensated, &phi, size, tests.start)?.smallest);
        }
        let healthy = self.run(&case.training, draw, &[])?;
        let (mut in_training, mut faults, mut incipient) = (Vec::new(), Vec::new(), None);
        if let Some(&channel) = channels.first() {
            let phi = self.unit_fault_response(trained, channel)?.0;
            for fault in &self.config().on_line.faults {
                in_training.push(line.in_training(&healthy, channel, *fault, &phi)?);
                faults.push(line.after(&with_fault(&healthy, channel, *fault, line.begins))?);
            }
            let fault = TrainingFault { size, rise_s: self.config().faults.rise_s };
            incipient = Some(line.after(&with_fault(&healthy, channel, fault, line.begins))?);
        }
        let said = line.after(&healthy)?;
        let jumpy = self.with_jumps(case, draw, line.begins)?;
        let jumps = line.after(&self.run(&case.training, &jumpy, &[])?)?;
        let length = self.samples(self.config().on_line.drift_s);
        let drift = match self.way(case, line.begins, length)? {
            None => None,
            Some(way) => Some(line.drift(&self.drifting_run(case, draw, &way)?)?),
        };
        let (primary, compensated) = trained.fault_free_maxima();
        Ok(Opened {
            fault_free: Pair { primary, compensated },
            false_alarms,
            smallest,
            in_training,
            healthy: said,
            jumps,
            faults,
            incipient: incipient.unwrap_or(said),
            drift,
        })
    }
}

impl Line<'_> {
    /// What a fault does that begins half way through the training.
    fn in_training(
        &mut self,
        healthy: &Record,
        channel: usize,
        fault: TrainingFault,
        phi: &[f64],
    ) -> Result<InTraining, EngineStudyError> {
        let begins = self.opened / 2;
        let trace = line_trace(&mut self.pipeline, &with_fault(healthy, channel, fault, begins))?;
        let first = |kind, from: usize| {
            let mut events = trace.events.iter().filter(|event| event.kind == kind);
            events.find_map(|event| usize::try_from(event.k).ok().filter(|&k| k >= from))
        };
        let reported = first(EventKind::HardFaultWhileTraining, begins);
        let opened = first(EventKind::Frozen, begins);
        let (mut alarm, mut shown) = (false, None);
        if let Some(opened) = opened {
            let end = (opened + 1 + self.begins - self.opened).min(trace.len());
            let open = (opened + 1..end).filter(|&k| trace.compensating[k]);
            alarm = open.clone().any(|k| trace.alarm[k]);
            let rows: Vec<usize> = open.collect();
            shown = shown_share(&trace, &rows, phi, fault.size);
        }
        let reported_s = reported.map(|k| (k - begins) as f64 * self.ts);
        Ok(InTraining { reported_s, opened: opened.is_some(), alarm, shown })
    }

    /// What is said of a run from the sample on in which something begins.
    fn after(&mut self, record: &Record) -> Result<Afterwards, EngineStudyError> {
        let trace = line_trace(&mut self.pipeline, record)?;
        Ok(self.afterwards(&trace))
    }

    /// What was said from the sample on in which something begins.
    fn afterwards(&self, trace: &Trace) -> Afterwards {
        let since = |k: usize| (k - self.begins) as f64 * self.ts;
        let changed = trace.events.iter().find_map(|event| {
            let k = usize::try_from(event.k).ok()?;
            (event.kind == EventKind::CharacteristicsChanged && k >= self.begins).then_some(k)
        });
        let after = self.begins..trace.len();
        let stated = after.clone().find(|&k| trace.alarm[k] && !trace.void[k]);
        let void = after.clone().filter(|&k| trace.void[k]).count();
        Afterwards {
            changed_s: changed.map(since),
            alarm_s: trace.first_alarm(self.begins).map(since),
            stated_alarm_s: stated.map(since),
            void: void as f64 / after.len().max(1) as f64,
        }
    }

    /// What becomes of an engine that drifts.
    fn drift(&mut self, record: &Record) -> Result<Drift, EngineStudyError> {
        let trace = line_trace(&mut self.pipeline, record)?;
        let said = self.afterwards(&trace);
        // The last word counts: what was learned in the middle of the drift may have to be learned again.
        let last = trace.events.iter().rev().find_map(|event| match event.kind {
            EventKind::Frozen | EventKind::CharacteristicsChanged => Some(*event),
            _ => None,
        });
        let learned_s = match (said.changed_s, last) {
            (Some(_), Some(event)) if event.kind == EventKind::Frozen => {
                usize::try_from(event.k).ok().map(|k| (k - self.begins) as f64 * self.ts)
            }
            _ => None,
        };
        let mut generator = self.trained.design().build().map_err(TrainingError::from)?;
        let residual = residual_record(&mut generator, record, 0)?;
        let bias =
            self.trained.bias_model().simulate_record(&residual).map_err(TrainingError::from)?;
        let channels = trace.channels;
        let lead = self.begins - self.opened;
        let rows = |values: &[f64], from: usize, to: usize| {
            rms(values[from * channels..to * channels].iter().copied())
        };
        let frozen: Vec<f64> = trace.residual.iter().zip(&bias).map(|(r, mu)| r - mu).collect();
        let (end, tail) = (trace.len(), trace.len().saturating_sub(lead));
        Ok(Drift {
            said,
            learned_s,
            before: rows(&trace.compensated, self.opened + 1, self.begins),
            old: rows(&frozen, tail, end),
            new: rows(&trace.compensated, tail, end),
        })
    }
}

fn line_trace(pipeline: &mut DynPipeline, record: &Record) -> Result<Trace, EngineStudyError> {
    pipeline.reset();
    Ok(Trace::of(pipeline, record).map_err(TrainingError::from)?)
}

/// A run with a fault of one sensor from a sample on.
fn with_fault(record: &Record, channel: usize, fault: TrainingFault, from: usize) -> Record {
    let mut faulty = record.clone();
    let rise = (fault.rise_s / record.ts().seconds()).max(f64::MIN_POSITIVE);
    for k in from..faulty.len() {
        let share = (((k - from) as f64 + 1.0) / rise).min(1.0);
        faulty.y_mut(k)[channel] += fault.size * share;
    }
    faulty
}

/// Mean `r*` of some samples along the lasting response to a fault, relative to a fault of that size.
fn shown_share(trace: &Trace, samples: &[usize], phi: &[f64], size: f64) -> Option<f64> {
    let lasting = phi.rchunks_exact(trace.channels.max(1)).next()?;
    let square: f64 = lasting.iter().map(|g| g * g).sum();
    if samples.is_empty() || square <= 0.0 {
        return None;
    }
    let row = |k: usize| trace.compensated[k * trace.channels..].iter().zip(lasting);
    let along: f64 = samples.iter().flat_map(|&k| row(k)).map(|(r, g)| r * g).sum();
    Some(along / (square * size * samples.len() as f64))
}
