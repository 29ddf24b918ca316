//! The output of a pipeline over a log, sample by sample, for reports.

use fd_core::{
    DynPipeline, Event, FrameError,
    stage::{Decision, Phase, Stage},
};
use fd_model::Record;

/// Missing samples in a row after which a diagnosis begins anew: its generator has lost the plant, and what it says before it
/// has settled again is no residual.
pub const LONGEST_GAP: usize = 5;

/// Signals and events of one log. All lists but `events` and `restarts` have one entry per sample of the log, or one per
/// sample and residual channel; where a sample was refused the signals are NaN.
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
    /// What happened, by samples of the log.
    pub events: Vec<Event>,
    /// Samples of the log with which the diagnosis began anew.
    pub restarts: Vec<usize>,
    /// Samples that were refused because they were missing for too long.
    pub refused: usize,
}

impl Trace {
    /// Runs `pipeline` over `record`, from wherever the pipeline stands.
    ///
    /// Samples that the pipeline refuses as missing are counted and not judged; after more than [`LONGEST_GAP`] of them in
    /// a row it begins anew, and settles.
    ///
    /// # Errors
    ///
    /// Returns an error when the log has other channels than the pipeline.
    pub fn of(pipeline: &mut DynPipeline, record: &Record) -> Result<Self, FrameError> {
        let channels = pipeline.stages().generator.residual_len();
        let mut trace = Self { channels, ..Self::default() };
        let mut gap = 0;
        for (k, (u, y)) in record.samples().enumerate() {
            trace.time.push(record.time(k));
            let is_complete = u.iter().chain(y).all(|value| value.is_finite());
            if is_complete && LONGEST_GAP < std::mem::take(&mut gap) {
                pipeline.reset();
                trace.restarts.push(k);
            }
            let step = match pipeline.step(u, y) {
                Ok(step) => step,
                Err(FrameError::NonFinite { .. }) => {
                    trace.refused += 1;
                    gap += 1;
                    trace.miss();
                    continue;
                }
                Err(error) => return Err(error),
            };
            trace.residual.extend_from_slice(step.residual);
            trace.compensated.extend_from_slice(step.compensated);
            trace.compensating.push(step.phase == Phase::Compensating);
            trace.statistic.push(step.verdict.statistic);
            trace.threshold.push(step.verdict.threshold);
            trace.alarm.push(step.decision.is_fault());
            trace.decision.push(step.decision);
            trace.events.extend(step.events.iter().map(|kind| Event { k: k as u64, kind }));
            trace.void.push(pipeline.is_void());
        }
        Ok(trace)
    }

    /// A sample that nothing is known of.
    fn miss(&mut self) {
        let none = std::iter::repeat_n(f64::NAN, self.channels);
        self.residual.extend(none.clone());
        self.compensated.extend(none);
        self.statistic.push(f64::NAN);
        self.threshold.push(f64::NAN);
        self.decision.push(Decision::Nominal);
        for flags in [&mut self.compensating, &mut self.alarm, &mut self.void] {
            flags.push(false);
        }
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
