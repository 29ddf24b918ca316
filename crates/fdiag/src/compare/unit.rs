//! One engine through every entry.

use fd_compensate::SampleRows;
use fd_model::Record;

use super::{
    config::{CompareConfig, Detector, Generator},
    isolate::Isolation,
    scene::{Runs, Scene},
    tally::{Alarms, Outcome, Role, Unit},
    watch::{margins, peak, residual},
};
use crate::{
    engine::EngineStudyError,
    road::{RoadError, Trace, Trained, sensor_signatures},
    spec::BiasSpec,
};

/// Seconds at the end of a run over which a fault is named.
const NAMING_S: f64 = 2.0;

impl Scene<'_> {
    /// Runs one engine. Entries that cannot be built on it say why; the error is for an engine that
    /// cannot be run at all.
    pub(super) fn unit(&self, seed: u64, role: Role<'_>) -> Result<Unit, EngineStudyError> {
        let runs = self.runs(seed, role)?;
        let config = self.config;
        let mut entries = Vec::with_capacity(config.entries());
        for generator in &config.generators {
            let fits: Vec<Option<Result<Fit, String>>> = config
                .biases
                .iter()
                .map(|bias| bias.spec.as_ref().map(|spec| Fit::new(config, generator, spec, &runs)))
                .collect();
            // The primary residual is the same whatever is learned from it.
            let primary = fits.iter().flatten().find(|fit| fit.is_ok());
            let learned;
            let primary = if let Some(fit) = primary {
                fit
            } else {
                learned = Fit::new(config, generator, &BiasSpec::default(), &runs);
                &learned
            };
            for fit in &fits {
                let (fit, compensated) = fit.as_ref().map_or((primary, false), |fit| (fit, true));
                let judge = fit.as_ref().map(|fit| Judge {
                    scene: self,
                    runs: &runs,
                    fit,
                    compensated,
                    role,
                });
                for detector in &config.detectors {
                    entries.push(match &judge {
                        Ok(judge) => judge.outcome(detector, entries.len()),
                        Err(reason) => Outcome::Failed((*reason).clone()),
                    });
                }
            }
        }
        Ok(Unit { scenario: self.index, seed, entries })
    }
}

/// A trained generator with its bias model, and all runs through both.
struct Fit {
    trained: Trained,
    healthy: Vec<Trace>,
    faulty: Vec<Vec<Vec<Trace>>>,
}

impl Fit {
    fn new(
        config: &CompareConfig,
        generator: &Generator,
        bias: &BiasSpec,
        runs: &Runs,
    ) -> Result<Self, String> {
        Self::try_new(config, generator, bias, runs).map_err(|error| error.to_string())
    }

    fn try_new(
        config: &CompareConfig,
        generator: &Generator,
        bias: &BiasSpec,
        runs: &Runs,
    ) -> Result<Self, RoadError> {
        let trained = runs.train(&config.pipeline(generator, bias))?;
        let watch = |record: &Record| trained.watch(record);
        let all = |records: &Vec<Record>| records.iter().map(watch).collect::<Result<_, _>>();
        let kinds = |kinds: &Vec<Vec<Record>>| kinds.iter().map(all).collect::<Result<_, _>>();
        let healthy = all(&runs.healthy)?;
        let faulty = runs.faulty.iter().map(kinds).collect::<Result<_, _>>()?;
        Ok(Self { trained, healthy, faulty })
    }
}

/// A fit as one detector after another sees it.
struct Judge<'a> {
    scene: &'a Scene<'a>,
    runs: &'a Runs,
    fit: &'a Fit,
    compensated: bool,
    role: Role<'a>,
}

impl Judge<'_> {
    fn outcome(&self, detector: &Detector, entry: usize) -> Outcome {
        self.try_outcome(detector, entry).unwrap_or_else(|error| Outcome::Failed(error.to_string()))
    }

    fn try_outcome(&self, detector: &Detector, entry: usize) -> Result<Outcome, RoadError> {
        let config = self.scene.config;
        let trained = &self.fit.trained;
        let (primary, compensated) = trained.calibration();
        let scale = if self.compensated { compensated } else { primary };
        let channels = trained.design().residual_len();
        let rows = SampleRows::new(channels, scale)?;
        let mut detector = trained.scaled(&detector.spec, scale)?;
        let mut margins = |(record, trace): (&Record, &Trace)| {
            margins(detector.as_mut(), record, residual(trace, self.compensated), config.rule)
        };
        let healthy = || self.runs.healthy.iter().zip(&self.fit.healthy);
        let factors = match self.role {
            Role::Thresholds => {
                let peaks = healthy().map(|run| peak(&margins(run)));
                return Ok(Outcome::Peaks(peaks.collect()));
            }
            Role::Test(factors) => match factors[entry].as_slice() {
                [] => return Ok(Outcome::Failed("no threshold could be set".to_owned())),
                factors => factors,
            },
        };
        let start = self.scene.fault_start();
        let isolation = Isolation::new(&sensor_signatures(trained)?, rows);
        let sizes: Vec<usize> = self.scene.kinds.iter().map(|kind| kind.sizes.len()).collect();
        let mut alarms = Alarms::none(&sizes, factors.len(), trained.design().io().ny);
        for run in healthy() {
            let peak = peak(&margins(run));
            alarms.healthy_runs += 1;
            for (count, factor) in alarms.healthy.iter_mut().zip(factors) {
                *count += u64::from(peak > *factor);
            }
        }
        let window = self.scene.samples(NAMING_S);
        for (record, faulty) in self.runs.healthy.iter().zip(&self.fit.faulty) {
            for (k, (kind, sizes)) in self.scene.kinds.iter().zip(faulty).enumerate() {
                let truth = self.scene.sensor(kind);
                for (s, trace) in sizes.iter().enumerate() {
                    let is_found = alarms.look((k, s), &margins((record, trace)), start, factors);
                    let (true, Some(isolation), Some(truth)) = (is_found, &isolation, truth) else {
                        continue;
                    };
                    let residual = residual(trace, self.compensated);
                    if let Some(named) = isolation.name(residual, window) {
                        alarms.confusion[truth][named] += 1;
                    }
                }
            }
        }
        Ok(Outcome::Alarms(alarms))
    }
}
