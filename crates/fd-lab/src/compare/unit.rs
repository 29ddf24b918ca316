//! One engine through every entry.

use std::cell::Cell;

use fd_compensate::SampleRows;
use fd_model::Record;
use fdiag::{
    spec::BiasSpec,
    training::{Trained, TrainingError, sensor_signatures},
};

use super::{
    config::CompareConfig,
    error::CompareError,
    isolate::Isolation,
    method::Detector,
    named::completed,
    plants::{Ask, Runs},
    residuals::Residuals,
    scene::Scene,
    tally::{Alarms, Outcome, Role, Unit},
    watch::{Fork, Levels, Watch},
};
use fdiag::Watcher;

/// Seconds at the end of a run over which a fault is named.
const NAMING_S: f64 = 2.0;

impl Scene<'_> {
    /// Runs one engine. Entries that cannot be built on it say why; the error is for an engine that
    /// cannot be run at all, or that nobody waits for any longer.
    pub(super) fn unit(
        &self,
        seed: u64,
        role: Role<'_>,
        watcher: &impl Watcher,
    ) -> Result<Unit, CompareError> {
        // Asked before what takes long, so that nothing finished is lost.
        let goes_on = || if watcher.is_stopped() { Err(CompareError::Stopped) } else { Ok(()) };
        goes_on()?;
        let (config, start) = (self.config, self.config.fault_start());
        let (fresh_runs, tested) = match role {
            Role::Thresholds => (config.engines.threshold_runs, false),
            Role::Test(_) => (config.engines.test_runs, true),
        };
        let runs = self.runs(Ask { seed, fresh_runs, tested })?;
        let mut entries = Vec::with_capacity(config.entries());
        // Simulated; then everything is trained once and judged once.
        let steps = 1 + 2 * config.generators.len() * config.biases.len();
        let done = Cell::new(0);
        let step = || {
            done.set(done.get() + 1);
            watcher.step(done.get(), steps);
        };
        step();
        for generator in &config.generators {
            let generator = completed(config, generator, &runs);
            let train = |bias: Option<&BiasSpec>| {
                let generator = generator.as_ref().map_err(String::clone)?;
                runs.train(&config.pipeline(generator, bias)).map_err(|error| error.to_string())
            };
            let biases = config.biases.iter();
            let fits: Vec<Option<Result<Trained, String>>> = biases
                .map(|bias| {
                    goes_on()?;
                    let fit = bias.spec.as_ref().map(|spec| train(Some(spec)));
                    step();
                    Ok(fit)
                })
                .collect::<Result<_, CompareError>>()?;
            // The primary residual is the same whatever is learned from it.
            let learned;
            let plain = if let Some(fit) = fits.iter().flatten().find(|fit| fit.is_ok()) {
                fit
            } else {
                learned = train(None);
                &learned
            };
            let primary = plain.as_ref().map_err(String::clone).and_then(|trained| {
                Residuals::primary(trained, &runs, start).map_err(|error| error.to_string())
            });
            for fit in &fits {
                goes_on()?;
                let judged = |trained: &Trained, residuals: &Residuals, scale: &[f64]| {
                    let judge = Judge::new(self, &runs, trained, residuals, scale)?;
                    Ok(judge.outcomes(role, entries.len()))
                };
                let outcomes = match (fit, plain, &primary) {
                    (Some(Err(reason)), ..) | (None, Err(reason), _) | (.., Err(reason)) => {
                        Err(reason.clone())
                    }
                    (Some(Ok(trained)), _, Ok(primary)) => primary
                        .compensated(trained, &runs, start)
                        .and_then(|own| judged(trained, &own, trained.calibration().1))
                        .map_err(|error| error.to_string()),
                    (None, Ok(trained), Ok(primary)) => {
                        judged(trained, primary, trained.calibration().0)
                            .map_err(|error| error.to_string())
                    }
                };
                match outcomes {
                    Ok(outcomes) => entries.extend(outcomes),
                    Err(reason) => {
                        let failed = Outcome::Failed(reason);
                        entries.extend(std::iter::repeat_n(failed, config.detectors.len()));
                    }
                }
                step();
            }
        }
        Ok(Unit { scenario: self.index, seed, entries })
    }
}

/// A generator with or without its bias model, as one detector after another sees it.
struct Judge<'a> {
    scene: &'a Scene<'a>,
    config: &'a CompareConfig,
    runs: &'a Runs,
    trained: &'a Trained,
    residuals: &'a Residuals,
    /// The fault-free residual that scales the detectors.
    scale: &'a [f64],
    isolation: Option<Isolation>,
}

impl<'a> Judge<'a> {
    fn new(
        scene: &'a Scene<'a>,
        runs: &'a Runs,
        trained: &'a Trained,
        residuals: &'a Residuals,
        scale: &'a [f64],
    ) -> Result<Self, TrainingError> {
        let rows = SampleRows::new(trained.design().residual_len(), scale)?;
        let isolation = Isolation::new(&sensor_signatures(trained)?, rows);
        Ok(Self { scene, config: scene.config, runs, trained, residuals, scale, isolation })
    }

    /// One outcome for each detector, the first of which is entry `first`.
    fn outcomes(&self, role: Role<'_>, first: usize) -> Vec<Outcome> {
        let outcome = |(i, detector): (usize, &Detector)| {
            let outcome = match role {
                Role::Thresholds => self.peaks(detector).map(Outcome::Peaks),
                Role::Test(factors) => match factors[first + i].as_slice() {
                    [] => return Outcome::Failed("no threshold could be set".to_owned()),
                    factors => self.alarms(detector, factors).map(Outcome::Alarms),
                },
            };
            outcome.unwrap_or_else(|error| Outcome::Failed(error.to_string()))
        };
        self.config.detectors.iter().enumerate().map(outcome).collect()
    }

    fn watch(&self, detector: &Detector) -> Result<Watch, TrainingError> {
        Ok(Watch::new(
            self.trained.scaled(&detector.spec, self.scale)?,
            self.config.rule,
            self.runs.unseen,
        ))
    }

    fn peaks(&self, detector: &Detector) -> Result<Vec<f64>, TrainingError> {
        let mut watch = self.watch(detector)?;
        let runs = self.runs.healthy.iter().zip(&self.residuals.healthy);
        Ok(runs.map(|(record, residual)| watch.peak(record, residual)).collect())
    }

    fn alarms(&self, detector: &Detector, factors: &[f64]) -> Result<Alarms, TrainingError> {
        let mut watch = self.watch(detector)?;
        let sizes: Vec<usize> = self.scene.kinds.iter().map(|kind| kind.sizes.len()).collect();
        let mut alarms = Alarms::none(&sizes, factors.len(), self.trained.design().io().ny);
        for (run, (record, residual)) in
            self.runs.healthy.iter().zip(&self.residuals.healthy).enumerate()
        {
            let peak = match self.residuals.faulty.get(run) {
                None => watch.peak(record, residual),
                Some(faulty) => {
                    let start = self.config.fault_start().min(record.len());
                    let channels = residual.len() / record.len().max(1);
                    let (before, after) = residual.split_at(start * channels);
                    let fork = watch.fork(record, before);
                    let rest = watch.rest(&fork, (record, start), after, Levels::NONE);
                    let peak = fork.peak.max(rest.peak);
                    let broken = &self.runs.faulty[run];
                    self.look(&mut watch, (&fork, peak), (broken, faulty), factors, &mut alarms);
                    peak
                }
            };
            alarms.healthy_runs += 1;
            for (count, factor) in alarms.healthy.iter_mut().zip(factors) {
                *count += u64::from(peak > *factor);
            }
        }
        Ok(alarms)
    }

    /// All faults on one run, which is as it was up to the fork; `healthy` is the largest margin that
    /// the run has without a fault.
    fn look(
        &self,
        watch: &mut Watch,
        (fork, healthy): (&Fork, f64),
        (records, faulty): (&[Vec<Record>], &[Vec<Vec<f64>>]),
        factors: &[f64],
        alarms: &mut Alarms,
    ) {
        let (start, window) = (self.config.fault_start(), self.config.samples(NAMING_S));
        // A margin above the highest factor that is not reached without a fault settles all.
        let open = factors.iter().copied().filter(|&factor| healthy <= factor);
        let Some(enough) = open.reduce(f64::max) else { return };
        let levels = Levels { alarm: factors[0], enough };
        for (k, (kind, sizes)) in self.scene.kinds.iter().zip(faulty).enumerate() {
            let truth = self.scene.sensor(kind);
            for (s, residual) in sizes.iter().enumerate() {
                let rest = watch.rest(fork, (&records[k][s], start), residual, levels);
                let is_found = alarms.look((k, s), healthy, rest, factors);
                let (true, Some(isolation), Some(truth)) = (is_found, &self.isolation, truth)
                else {
                    continue;
                };
                if let Some(named) = isolation.name(residual, window) {
                    alarms.confusion[truth][named] += 1;
                }
            }
        }
    }
}
