//! A log as one mistake makes it, simulated and fitted.

use std::sync::Arc;

use fd_model::Record;
use fd_sim::{
    model::Model,
    simulate::{Run, Simulator},
};

use super::{
    misfit::{Look, Misfit},
    mistake::Mistake,
};
use crate::{
    diagnose::Case,
    fit::{AT_A_TIME, FitError, Horizon, Log, Plan, Problem, Search, Weights, minimise},
    quality::{grid_step, robust_third_difference_floor},
};

/// Steps of a fit of the nuisances: enough to see where it goes.
const STEPS: usize = 10;
/// Samples of a log that are enough to judge a slower clock by.
const BEGINNING: usize = 100;

/// A log as one mistake makes it, with the simulator that it is compared with.
#[derive(Debug)]
pub(super) struct Trial<'a> {
    mistake: Option<&'a Mistake>,
    simulator: Box<dyn Simulator>,
    logs: Vec<Log>,
    floors: Vec<f64>,
}

impl<'a> Trial<'a> {
    /// The logs of a case with a mistake mended; `None` stands for the log as it is read.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    pub(super) fn new(case: &Case<'_>, mistake: Option<&'a Mistake>) -> Result<Self, FitError> {
        let ts = case.logs.first().ok_or(FitError::NoLog)?.ts();
        let Some(known) = mistake else {
            let simulator = case.nominal.simulator(ts)?;
            let logs = Log::all(case.logs, &*simulator, &[])?;
            return Ok(Self::with(mistake, case.nominal.model(), simulator, logs));
        };
        let mended = |record: &Record| -> Result<Record, FitError> {
            let record = known.mended(record).ok_or(FitError::Diverged)?;
            // A slower clock takes as many more steps: the beginning has to do.
            let Mistake::Time { factor } = known else { return Ok(record) };
            let samples = BEGINNING.max((factor * record.len() as f64) as usize);
            let samples = samples.min(record.len());
            Ok(record.slice(0, samples))
        };
        let records = case.logs.iter().map(mended).collect::<Result<Vec<_>, _>>()?;
        let model = known.mended_model(case.nominal.model()).ok_or(FitError::Diverged)?;
        let ts = records.first().map_or(ts, Record::ts);
        let simulator = case.nominal.patched(&model, ts)?;
        let logs = Log::all(&records, &*simulator, &[])?;
        Ok(Self::with(mistake, &model, simulator, logs))
    }

    /// Logs that were mended already, with the simulator of their case.
    pub(super) fn of_mended(case: &Case<'_>, mistake: &'a Mistake) -> Result<Self, FitError> {
        let ts = case.logs.first().ok_or(FitError::NoLog)?.ts();
        let simulator = case.nominal.simulator(ts)?;
        let logs = Log::all(case.logs, &*simulator, &[])?;
        Ok(Self::with(Some(mistake), case.nominal.model(), simulator, logs))
    }

    fn with(
        mistake: Option<&'a Mistake>,
        model: &Model,
        simulator: Box<dyn Simulator>,
        logs: Vec<Log>,
    ) -> Self {
        let floor = |(c, output): (usize, &fd_sim::model::Output)| floor(&logs, c, output.noise);
        let floors = model.outputs.iter().enumerate().map(floor).collect();
        Self { mistake, simulator, logs, floors }
    }

    /// The simulator.
    pub(super) fn simulator(&self) -> &dyn Simulator {
        &*self.simulator
    }

    /// Outputs that are zero all the time.
    pub(super) fn zeros(&self) -> Vec<Vec<f64>> {
        self.logs.iter().map(|log| vec![0.0; log.y.len()]).collect()
    }

    /// What a simulation leaves.
    pub(super) fn misfit(&self, simulated: &[Vec<f64>], look: Look) -> Option<Misfit> {
        let names: Vec<&str> = self.simulator.outputs().iter().map(|y| y.name.as_str()).collect();
        Misfit::of(self.mistake, &names, &self.logs, simulated, &self.floors, look)
    }

    /// A plain simulation with everything at its nominal value.
    pub(super) fn simulated(&mut self) -> Option<Vec<Vec<f64>>> {
        let theta: Vec<f64> = self.simulator.parameters().iter().map(|p| p.value).collect();
        match self.simulator.stand_in() {
            // A mistake is only suspected here: that needs no run of a simulator that is dear.
            Some(mut stand_in) => {
                let with_rows = |log: &Log| log.with_rows();
                runs(&mut *stand_in, &self.logs, with_rows, &[theta]).pop()?
            }
            None => self.simulated_with(&[theta]).pop()?,
        }
    }

    /// The same with several sets of parameters; `None` where one diverges.
    pub(super) fn simulated_with(&mut self, sets: &[Vec<f64>]) -> Vec<Option<Vec<Vec<f64>>>> {
        runs(&mut *self.simulator, &self.logs, |log| log.u.clone(), sets)
    }

    /// What is left once parameters and starts have done what they can.
    pub(super) fn fitted(&self, horizon: Horizon) -> Option<Misfit> {
        // A log that was cut anew begins in motion; so may any other.
        let logs = self.logs.iter().map(|log| log.clone().in_motion()).collect();
        let plan = Plan::of_logs(&*self.simulator, logs, horizon).ok()?;
        let weights = Weights::white(self.floors.clone());
        let problem = Problem::new(Arc::new(plan), self.simulator.boxed(), vec![], weights);
        let mut problem = problem.ok()?.on_stand_in();
        let origin = vec![0.0; crate::fit::LeastSquares::layout(&problem).unknowns()];
        let search = Search { iterations: STEPS, ..Search::default() };
        let minimum = minimise(&mut problem, &origin, None, search)?;
        self.misfit(&problem.outputs(&minimum.z)?, Look::Close)
    }
}

/// Runs through logs, of which `inputs` gives the inputs, with several sets of parameters; `None` where one
/// diverges.
fn runs(
    simulator: &mut dyn Simulator,
    logs: &[Log],
    inputs: impl Fn(&Log) -> Vec<f64>,
    sets: &[Vec<f64>],
) -> Vec<Option<Vec<Vec<f64>>>> {
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let mut all: Vec<Option<Vec<Vec<f64>>>> = vec![Some(Vec::new()); sets.len()];
    for log in logs {
        let u = inputs(log);
        for (sets, found) in sets.chunks(AT_A_TIME).zip(all.chunks_mut(AT_A_TIME)) {
            let mut outputs = vec![vec![0.0; log.y.len()]; sets.len()];
            let pairs = sets.iter().zip(&mut outputs);
            let mut runs: Vec<Run<'_>> = pairs.map(|(theta, y)| Run::new(theta, &x0, y)).collect();
            simulator.simulate_many(0, &u, &mut runs);
            for (y, found) in outputs.into_iter().zip(found) {
                let is_finite = y.iter().all(|value| value.is_finite());
                match found {
                    Some(logs) if is_finite => logs.push(y),
                    diverged => *diverged = None,
                }
            }
        }
    }
    all
}

/// The least noise of an output that is believed: what is stated, and the grid of its values; where
/// nothing is stated, what third differences show.
fn floor(logs: &[Log], output: usize, stated: Option<f64>) -> f64 {
    let column =
        |log: &Log| -> Vec<f64> { log.y.iter().skip(output).step_by(log.ny).copied().collect() };
    let measured = logs.iter().map(column).collect::<Vec<_>>().join(&f64::NAN);
    let largest = measured.iter().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs()));
    let smallest = (1e-6 * largest).max(f64::MIN_POSITIVE);
    let shown = || robust_third_difference_floor(&measured).unwrap_or(smallest);
    let noise = stated.filter(|noise| 0.0 < *noise).unwrap_or_else(shown);
    let rounding = grid_step(&measured).map_or(0.0, |step| step / 12.0_f64.sqrt());
    noise.max(rounding).max(smallest)
}
