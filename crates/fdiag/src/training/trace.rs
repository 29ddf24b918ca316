//! The output of a pipeline over a log, sample by sample, for reports.

use fd_core::{
    DynPipeline, Event, FrameError,
    stage::{Decision, Phase},
};
use fd_model::Record;

/// Signals and events of one log. All lists but `events` have one entry per sample, or one per
/// sample and residual channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Time in s.
    pub time: Vec<f64>,
    /// Residual channels.
    pub channels: usize,
    /// Primary residual, sample by sample.
    pub residual: Vec<f64>,
    /// Compensated residual, sample by sample.
    pub compensated: Vec<f64>,
    /// Whether the bias was being subtracted.
    pub compensating: Vec<bool>,
    /// Test statistic.
    pub statistic: Vec<f64>,
    /// Threshold of the test statistic.
    pub threshold: Vec<f64>,
    /// Whether a fault was reported.
    pub alarm: Vec<bool>,
    /// Whether the inputs were beyond anything that the threshold was set on.
    pub void: Vec<bool>,
    /// What was decided.
    pub decision: Vec<Decision<f64>>,
    /// What happened.
    pub events: Vec<Event>,
    /// Samples that were refused because they were missing for too long.
    pub refused: usize,
}

impl Trace {
    /// Runs `pipeline` over `record`, from wherever the pipeline stands.
    ///
    /// Samples that the pipeline refuses as missing are counted and left out.
    ///
    /// # Errors
    ///
    /// Returns an error when the log has other channels than the pipeline.
    pub fn of(pipeline: &mut DynPipeline, record: &Record) -> Result<Self, FrameError> {
        let mut trace = Self::default();
        for (k, (u, y)) in record.samples().enumerate() {
            let step = match pipeline.step(u, y) {
                Ok(step) => step,
                Err(FrameError::NonFinite { .. }) => {
                    trace.refused += 1;
                    continue;
                }
                Err(error) => return Err(error),
            };
            trace.channels = step.residual.len();
            trace.time.push(record.time(k));
            trace.residual.extend_from_slice(step.residual);
            trace.compensated.extend_from_slice(step.compensated);
            trace.compensating.push(step.phase == Phase::Compensating);
            trace.statistic.push(step.verdict.statistic);
            trace.threshold.push(step.verdict.threshold);
            trace.alarm.push(step.decision.is_fault());
            trace.decision.push(step.decision);
            trace.events.extend(step.events.iter().map(|kind| Event { k: step.k, kind }));
            trace.void.push(pipeline.is_void());
        }
        Ok(trace)
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// A residual channel while the bias was subtracted; `rows` are `residual` or `compensated`.
    pub fn while_compensating<'a>(
        &'a self,
        rows: &'a [f64],
        channel: usize,
    ) -> impl Iterator<Item = f64> + 'a {
        let rows = rows.chunks_exact(self.channels.max(1)).zip(&self.compensating);
        rows.filter(|(_, on)| **on).map(move |(row, _)| row[channel])
    }

    /// Largest magnitudes of the primary and the compensated residual over the samples in which
    /// the bias was subtracted, all channels together; `None` when there are none.
    #[must_use]
    pub fn maxima(&self) -> Option<(f64, f64)> {
        let mut maxima: Option<(f64, f64)> = None;
        let rows = self.residual.chunks(self.channels.max(1));
        let rows = rows.zip(self.compensated.chunks(self.channels.max(1)));
        for ((r, r_star), _) in rows.zip(&self.compensating).filter(|(_, on)| **on) {
            let peak = |row: &[f64]| row.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let (a, b) = maxima.unwrap_or((0.0, 0.0));
            maxima = Some((a.max(peak(r)), b.max(peak(r_star))));
        }
        maxima
    }

    /// First sample at or after `from` with a reported fault.
    #[must_use]
    pub fn first_alarm(&self, from: usize) -> Option<usize> {
        (from..self.len()).find(|&k| self.alarm[k])
    }
}
