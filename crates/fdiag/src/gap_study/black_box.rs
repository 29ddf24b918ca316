//! Requests of a study to an outside simulator beyond runs.

use fd_gap::fit::Log;
use fd_model::SampleTime;
use fd_sim::simulate::{Nominal, Run};

use super::{error::GapError, subject::Subject};

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
