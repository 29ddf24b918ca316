//! How small a fault could be at most: what the engine itself would leave if it were the model.

use fd_core::Heap;
use fd_model::Record;

use crate::engine::{
    Benchmark, Case, Draw, EngineStudyError, Reality,
    logs::{Draws, Logs},
};

/// The same runs as if the engine were linear: outputs of the linear model, and the noise that was in each run. On them
/// the linear observer leaves what it leaves of the noise, as it would of measured minus exactly simulated outputs.
pub(super) fn as_if_linear(
    benchmark: &Benchmark,
    case: &Case,
    draws: &Draws,
    logs: &Logs,
) -> Result<Logs, EngineStudyError> {
    let linear = Reality::Linear(case.model.freeze::<f64, Heap>()?);
    let one =
        |plant: &Reality, draw: &Draw, measured: &Record| -> Result<Record, EngineStudyError> {
            let silent = Draw { output_noise: Vec::new(), ..draw.clone() };
            let exact = benchmark.run(plant, &silent, &[])?;
            let mut record = benchmark.run(&linear, &silent, &[])?;
            for k in 0..record.len() {
                let noise = measured.y(k).iter().zip(exact.y(k)).map(|(y, exact)| y - exact);
                record.y_mut(k).iter_mut().zip(noise).for_each(|(y, noise)| *y += noise);
            }
            Ok(record)
        };
    let all = |plant: &Reality,
               draws: &[Draw],
               logs: &[Record]|
     -> Result<Vec<Record>, EngineStudyError> {
        draws.iter().zip(logs).map(|(draw, log)| one(plant, draw, log)).collect()
    };
    Ok(Logs {
        training: one(&case.training, &draws.training, &logs.training)?,
        calibration: all(&case.training, &draws.calibration, &logs.calibration)?,
        tests: all(&case.moved, &draws.tests, &logs.tests)?,
    })
}

#[cfg(test)]
mod tests {
    use fdiag::{spec::GeneratorSpec, training::residual_record};

    use super::*;
    use crate::engine::joined::scenarios;

    /// Without noise nothing is left, where the linear observer leaves the bias of the same runs.
    #[test]
    fn an_exact_model_leaves_the_noise_alone() {
        let mut config = scenarios().swap_remove(1).config;
        config.plant.noise = 0.0;
        (config.calibration_runs, config.test_runs) = (1, 1);
        let benchmark = Benchmark::new(config).unwrap();
        let mut case = benchmark.case(3).unwrap();
        let draws = benchmark.draws(&mut case).unwrap();
        let logs = benchmark.logs_of(&case, &draws).unwrap();
        let exact = as_if_linear(&benchmark, &case, &draws, &logs).unwrap();
        let observer = GeneratorSpec::Observer { rate: 2.0 };
        let design = observer.design(case.plant(), None, &[]).unwrap();
        let left = |record: &Record| {
            let mut generator = design.build().unwrap();
            let r = residual_record(&mut *generator, record, 0).unwrap();
            (0..r.len()).flat_map(|k| r.y(k).to_vec()).fold(0.0, |m: f64, r| m.max(r.abs()))
        };
        // Rounding of outputs of size 0.1, in a stable observer.
        assert!(left(&exact.tests[0]) < 1e-12, "{}", left(&exact.tests[0]));
        assert!(1e-5 < left(&logs.tests[0]), "{}", left(&logs.tests[0]));
    }
}
