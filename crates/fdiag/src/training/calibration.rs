//! What both residuals look like in healthy data: as a log goes on, and as a diagnosis begins.

use std::ops::Range;

use fd_core::{
    Frame,
    stage::{Compensator, Phase},
};
use fd_model::Record;

use super::{
    begin::forgotten_after,
    bias::LearnedBias,
    error::TrainingError,
    fault_free::FaultFree,
    healthy::Healthy,
    pay::{self, Applied, Payment},
    trace::Trace,
    trained::Trained,
};
use crate::spec::StartSpec;

/// How many beginnings thresholds are calibrated on, all logs together: the rate of a threshold for one run in twenty
/// then scatters by half of itself, as that of the rest does where it is resolved.
const BEGINNINGS: usize = 100;

impl Trained {
    /// What both residuals look like in healthy data.
    pub(super) fn calibrate(&mut self, healthy: &[Healthy<'_>]) -> Result<(), TrainingError> {
        (self.healthy, self.beginnings) = (FaultFree::default(), FaultFree::default());
        let logs = || healthy.iter().filter(|log| !log.calibrate.is_empty());
        for log in logs() {
            self.calibrate_on(log, BEGINNINGS.div_ceil(logs().count()))?;
        }
        Ok(())
    }

    /// Subtracts a constant or nothing in every channel in which the bias model does not pay.
    pub(super) fn apply_where_it_pays(
        &mut self,
        healthy: &[Healthy<'_>],
        moves: bool,
    ) -> Result<(), TrainingError> {
        let terms = pay::Terms { moves, means: &self.means, apply: self.spec.bias.apply };
        self.payments = pay::payments(&self.healthy, &terms);
        let pays = self.payments.iter().any(|payment| payment.applied == Applied::Bias);
        if pays && matches!(self.bias, LearnedBias::StateSpace(_)) {
            // One model for all channels cannot be divided.
            self.payments.iter_mut().for_each(|payment| payment.applied = Applied::Bias);
        }
        let of_channel = |(payment, mean): (&Payment, &f64)| match payment.applied {
            Applied::Bias => None,
            Applied::Constant => Some(*mean),
            Applied::Nothing => Some(0.0),
        };
        let constants: Vec<Option<f64>> =
            self.payments.iter().zip(&self.means).map(of_channel).collect();
        if constants.iter().all(Option::is_none) {
            return Ok(());
        }
        self.bias = self.bias.but_for(&constants, self.nominal.domain().ts, self.design.io().nu)?;
        self.fit.theta = self.bias.loaded();
        self.calibrate(healthy)
    }

    /// Adds what both residuals look like in healthy data, and how `beginnings` diagnoses begin that are started
    /// within it, with a generator that has settled as the log goes on. Where nothing has to settle, a diagnosis begins
    /// as it goes on; one that trains first begins with each log.
    fn calibrate_on(&mut self, log: &Healthy<'_>, beginnings: usize) -> Result<(), TrainingError> {
        let trace = self.watch(log.record)?;
        // One that trains first has learned from nothing that comes after its switch is open.
        let unlearned = match self.spec.start {
            StartSpec::Fitted => log.calibrate.clone(),
            StartSpec::Training => 0..log.record.len(),
        };
        self.healthy.append(log.record, &trace, unlearned);
        if self.fit.filling == 0 || self.spec.start != StartSpec::Fitted {
            return Ok(());
        }
        let end = log.calibrate.end.min(trace.len());
        let samples = end.saturating_sub(log.calibrate.start);
        let filling = usize::try_from(self.fit.filling).unwrap_or(usize::MAX);
        // In a stretch shorter than a start-up as much of it is seen as there is: the largest of it comes first.
        let length = filling.saturating_add(self.start_up()?).min(samples);
        if length <= filling {
            return Ok(());
        }
        let places = samples - length + 1;
        let beginnings = beginnings.min(places);
        for i in 0..beginnings {
            let from = log.calibrate.start + i * places / beginnings;
            if (from..from + length).all(|k| log.record.is_complete(k)) {
                self.begin_at(from..from + length, log.record, &trace)?;
            }
        }
        Ok(())
    }

    /// Adds how a compensator begins on these samples of a log.
    fn begin_at(
        &mut self,
        samples: Range<usize>,
        record: &Record,
        trace: &Trace,
    ) -> Result<(), TrainingError> {
        let mut compensator = self.compensator()?;
        let io = self.design.io();
        let start = self.beginnings.samples;
        let mut compensated = vec![0.0; trace.channels];
        for (k, at) in samples.enumerate() {
            let residual = &trace.residual[at * trace.channels..(at + 1) * trace.channels];
            let frame = Frame::new(io, k as u64, record.u(at), record.y(at))?;
            let phase = compensator.step(frame, residual, &mut compensated).phase;
            if phase == Phase::Compensating {
                self.beginnings.push(record.u(at), residual, &compensated);
            }
        }
        self.beginnings.begun_at(start);
        Ok(())
    }

    /// Samples until the bias model has forgotten the noise in its first past values: five time constants of its
    /// slowest pole, and the samples of the debouncing.
    fn start_up(&self) -> Result<usize, TrainingError> {
        let radii = self.bias.pole_radii()?;
        let slowest = radii.into_iter().flatten().fold(0.0, f64::max);
        let debounced = usize::try_from(self.spec.rule.out_of).unwrap_or(usize::MAX);
        Ok(forgotten_after(slowest).saturating_add(debounced))
    }
}
