//! Everything that is simulated for one seed before a diagnosis is made.

use fd_model::Record;

use super::{
    benchmark::{Benchmark, Case, Draw},
    error::EngineStudyError,
    reality::Reality,
};

/// Everything that is simulated for one seed before a diagnosis is made.
pub(super) struct Logs {
    pub training: Record,
    pub calibration: Vec<Record>,
    pub tests: Vec<Record>,
}

/// What is random in these runs.
pub(super) struct Draws {
    pub training: Draw,
    pub calibration: Vec<Draw>,
    pub tests: Vec<Draw>,
}

impl Benchmark {
    /// The runs of a seed.
    pub(super) fn logs(&self, case: &mut Case) -> Result<Logs, EngineStudyError> {
        let draws = self.draws(case)?;
        self.logs_of(case, &draws)
    }

    /// What is random in the runs of a seed.
    pub(super) fn draws(&self, case: &mut Case) -> Result<Draws, EngineStudyError> {
        let training = self.draw_training(case)?;
        let mut fresh = |count: usize| -> Result<Vec<Draw>, EngineStudyError> {
            (0..count).map(|_| self.draw_fresh(case)).collect()
        };
        let calibration = fresh(self.config().calibration_runs)?;
        Ok(Draws { training, calibration, tests: fresh(self.config().test_runs)? })
    }

    /// The runs that were drawn.
    pub(super) fn logs_of(&self, case: &Case, draws: &Draws) -> Result<Logs, EngineStudyError> {
        let all = |plant: &Reality, draws: &[Draw]| -> Result<Vec<Record>, EngineStudyError> {
            draws.iter().map(|draw| self.run(plant, draw, &[])).collect()
        };
        Ok(Logs {
            training: self.run(&case.training, &draws.training, &[])?,
            calibration: all(&case.training, &draws.calibration)?,
            tests: all(&case.moved, &draws.tests)?,
        })
    }
}
