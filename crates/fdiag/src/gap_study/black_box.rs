//! Requests of a study to an outside simulator beyond runs.

use fd_gap::fit::Log;
use fd_model::SampleTime;
use fd_sim::simulate::{Nominal, Run, Simulator};

use super::{data::Data, error::GapError, log_finding::LogFinding, subject::Subject};

impl Subject {
    /// Of a simulator outside of this program: the values that its parameters get, those of its own effects last, and
    /// whether its inputs, forces and outputs are passed on as they are. `None` where it is equations.
    ///
    /// # Errors
    ///
    /// Returns an error when a parameter cannot be computed.
    pub fn handed_on(&self) -> Result<Option<(Vec<f64>, bool)>, GapError> {
        let Some((_, shell)) = self.black_box() else { return Ok(None) };
        Ok(Some((shell.handed_on(shell.model())?, shell.passes_on(shell.model())?)))
    }

    /// Makes equal runs of a simulator through the first log, and says of each output by how much they differ.
    pub(super) fn unrepeated(&self, data: &Data) -> Result<Vec<LogFinding>, GapError> {
        let Some((outside, shell)) = self.black_box() else { return Ok(Vec::new()) };
        let Some(ts) = data.ts() else { return Ok(Vec::new()) };
        let [logs, _] = data.logs(&*shell.simulator(ts)?)?;
        let Some(log) = logs.first() else { return Ok(Vec::new()) };
        // The simulator may step several times per sample: the shell has seen that it is a whole number.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "whole and at least 1"
        )]
        let steps = (ts.seconds() / outside.ts().seconds()).round() as usize;
        let rows = (0..log.samples() * steps).flat_map(|k| log.input(k / steps).to_vec());
        let first = log.first() as u64 * steps as u64;
        let u: Vec<f64> = rows.collect();
        let Some(spread) = outside.measure_spread(first, &u, log.samples() * steps) else {
            return Ok(Vec::new());
        };
        let each = outside.outputs().iter().zip(&spread.deviation);
        let findings =
            each.filter(|(_, deviation)| 0.0 < **deviation).map(|(output, deviation)| {
                LogFinding::of_simulator(&outside.contract().name, output, *deviation, spread.runs)
            });
        Ok(findings.collect())
    }

    /// Runs a simulator that makes whole runs only through all logs, so that it knows what comes next where it is asked
    /// for steps.
    pub(super) fn show(&self, logs: &[Vec<Log>], ts: SampleTime) -> Result<(), GapError> {
        let Some((outside, shell)) = self.black_box() else { return Ok(()) };
        if outside.contract().powers.step {
            return Ok(());
        }
        let mut simulator = shell.simulator(ts)?;
        let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
        for log in logs.iter().flatten() {
            let mut y = vec![0.0; log.samples() * simulator.outputs().len()];
            let u: Vec<f64> = (0..log.samples()).flat_map(|k| log.input(k).to_vec()).collect();
            let mut runs = [Run::new(&theta, &x0, &mut y)];
            simulator.simulate_many(log.first() as u64, &u, &mut runs);
        }
        Ok(())
    }
}
