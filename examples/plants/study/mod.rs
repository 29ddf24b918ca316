//! Plants that differ from their model: which residual finds which fault at the same rate of false alarms, with and
//! without compensation, for several detectors. Each plant brings its model file, its faults and a way to run it.
#![allow(clippy::print_stderr, reason = "an example prints")]

mod table;

use std::{env, error::Error};

use faer::Mat;
use fdiag::{
    core::stage::Detector,
    model::{ChannelScale, Record, SampleTime, Scaling, StateSpace},
    nonlinear::{OperatingPoint, linearise},
    sim::{model::Model, simulate::StateMap},
    spec::{DetectorSpec, NominalPlant, PipelineSpec},
    training::train_on,
};
use rayon::prelude::*;

/// What a plant or a study gives, or why not.
pub(crate) type Outcome<T> = Result<T, Box<dyn Error>>;

/// Runs of a plant for the scale of its detectors, and for thresholds or results.
const CALIBRATION: u64 = 4;
pub(crate) const RUNS: u64 = 5;
/// Share of fault-free runs that may alarm.
pub(crate) const FALSE_ALARMS: f64 = 0.05;

/// A fault, with the unit of its size and the sizes that are tried, smallest first.
pub(crate) struct Fault {
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    /// As published, or a range that is divided evenly in the logarithm.
    pub(crate) sizes: Sizes,
}

#[derive(Clone, Copy)]
pub(crate) enum Sizes {
    #[allow(dead_code, reason = "not every plant has published sizes")]
    Published,
    #[allow(dead_code, reason = "not every plant has ranges")]
    Range { smallest: f64, largest: f64, count: usize },
}

impl Sizes {
    pub(crate) fn count(self) -> usize {
        match self {
            Self::Published => 1,
            Self::Range { count, .. } => count,
        }
    }

    /// The size at a place among the sizes, whole or between two.
    pub(crate) fn at(self, place: f64) -> f64 {
        match self {
            Self::Published => 1.0,
            Self::Range { smallest, largest, count } => {
                smallest * (largest / smallest).powf(place / (count - 1) as f64)
            }
        }
    }
}

/// Everything that the study has to know of a plant.
pub(crate) struct Study<'a> {
    /// Text of the model file.
    pub(crate) model: &'static str,
    pub(crate) ts_s: f64,
    /// Sample at which faults begin; alarms count from here to the end, in runs without faults too.
    pub(crate) onset: usize,
    pub(crate) settle_s: f64,
    pub(crate) faults: &'static [Fault],
    /// Generators by name, each with its lines of a spec, in which `MODEL` stands for the text of the model.
    pub(crate) generators: &'static [(&'static str, &'static str)],
    /// Compensators by name, each with its table `[bias]`; the first is none.
    pub(crate) compensators: &'static [(&'static str, &'static str)],
    /// Where the model is linearised, and what is an ordinary change of each state and input there.
    pub(crate) at: OperatingPoint,
    /// Outputs there, and an ordinary change of each.
    pub(crate) y: Vec<f64>,
    pub(crate) dy: Vec<f64>,
    /// One run of a plant: its number, the seed of the run, and a fault with its size.
    #[allow(clippy::type_complexity, reason = "said once")]
    pub(crate) run: &'a (dyn Fn(u64, u64, Option<(usize, f64)>) -> Outcome<Record> + Sync),
}

/// Detectors by name, each with its line of a spec; the first one has the whole table.
const DETECTORS: [(&str, &str); 3] = [
    ("chi-square of 20 samples", "kind = 'chi-square'\nwindow = 20\nfalse_alarms = RATE"),
    ("largest channel", "kind = 'n-sigma'\nfalse_alarms = RATE"),
    ("cumulative sum", "kind = 'cusum'\nfalse_alarms = RATE"),
];

fn detectors() -> Outcome<Vec<DetectorSpec>> {
    let rate = "{ kind = 'per-run', probability = 0.05, samples = 1000 }";
    DETECTORS.iter().map(|(_, line)| Ok(toml::from_str(&line.replace("RATE", rate))?)).collect()
}

/// What one plant gave, per entry: a generator, a compensator and a detector.
#[derive(Default)]
struct Unit {
    /// Largest statistics of healthy runs.
    healthy: Vec<Vec<f64>>,
    /// Per fault and size: samples from the onset to the first alarm, if there was one.
    found: Vec<Vec<Vec<Option<usize>>>>,
}

impl Study<'_> {
    /// The linear model of one sample, in units of ordinary changes.
    fn linear(&self, model: &Model, ts: SampleTime) -> Outcome<StateSpace<fdiag::model::Discrete>> {
        let map = StateMap::new(model, &model.nominal(), ts)?;
        let p = linearise(&map, &self.at, ts)?;
        let (dx, du, dy) = (&self.at.dx, &self.at.du, &self.dy);
        let scaled = |m: faer::MatRef<'_, f64>, to: &[f64], from: &[f64]| {
            Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * from[j] / to[i])
        };
        let (a, b) = (scaled(p.a(), dx, dx), scaled(p.b(), dx, du));
        Ok(StateSpace::new(a, b, scaled(p.c(), dy, dx), scaled(p.d(), dy, du), p.domain())?)
    }

    fn scaling(&self) -> Scaling {
        let of = |values: &[f64], changes: &[f64]| {
            values.iter().zip(changes).map(|(&v, &d)| ChannelScale::per_unit(v, d)).collect()
        };
        Scaling { inputs: of(&self.at.u, &self.at.du), outputs: of(&self.y, &self.dy) }
    }

    /// All entries on one plant; with `factors`, which statistics are alarms, the faulty runs too.
    fn unit(&self, plant: u64, factors: Option<&[f64]>) -> Outcome<Unit> {
        let scaling = self.scaling();
        let run = |purpose: u64, fault| -> Outcome<Record> {
            Ok((self.run)(plant, 1_000_000 * plant + purpose, fault)?.scaled(&scaling)?)
        };
        let model: Model = self.model.parse()?;
        let system = self.linear(&model, SampleTime::new(self.ts_s)?)?;
        let training = run(0, None)?;
        let calibration = (1..=CALIBRATION).map(|i| run(i, None)).collect::<Outcome<Vec<_>>>()?;
        let healthy = (10..10 + RUNS).map(|i| run(i, None)).collect::<Outcome<Vec<_>>>()?;
        let mut faulty = Vec::new();
        if factors.is_some() {
            for (kind, fault) in self.faults.iter().enumerate() {
                for i in 0..fault.sizes.count() {
                    // The same surroundings and noise as the first healthy run.
                    faulty.push(run(10, Some((kind, fault.sizes.at(i as f64))))?);
                }
            }
        }
        let mut unit = Unit::default();
        for (name, line) in self.generators {
            for (way, (compensator, bias)) in self.compensators.iter().enumerate() {
                let text = format!(
                    "settle_s = {:?}\n[generator]\n{}\n[bias]\n{bias}\n[detector]\n{}\n",
                    self.settle_s,
                    line.replace("MODEL", &format!("'''\n{}'''", self.model)),
                    "kind = 'n-sigma'",
                );
                let spec: PipelineSpec =
                    toml::from_str(&text).map_err(|e| format!("{name}, {compensator}: {e}"))?;
                let nominal = NominalPlant::from(&system).in_units(scaling.clone());
                let trained = match train_on(&spec, nominal, &training, &calibration) {
                    Ok(trained) => trained,
                    // A user would be told; here it counts as one plant less.
                    Err(error) => {
                        eprintln!("plant {plant}, {name}, {compensator}: {error}");
                        for _ in DETECTORS {
                            unit.healthy.push(Vec::new());
                            unit.found.push(Vec::new());
                        }
                        continue;
                    }
                };
                let (raw, clean) = trained.calibration();
                let scale = if way == 0 { raw } else { clean };
                let (mut primary, mut subtraction) = (trained.primary()?, trained.subtraction()?);
                let mut residuals = |records: &[Record]| -> Outcome<Vec<Vec<f64>>> {
                    let of = |record: &Record| -> Outcome<Vec<f64>> {
                        let r = primary.whole(record, self.onset)?;
                        if way == 0 { Ok(r) } else { Ok(subtraction.of(record, &r)?.residual) }
                    };
                    records.iter().map(of).collect()
                };
                let (quiet, loud) = (residuals(&healthy)?, residuals(&faulty)?);
                for detector in detectors()? {
                    let mut detector = trained.scaled(&detector, scale)?;
                    let channels = trained.design().residual_len();
                    let mut statistics = |record: &Record, r: &[f64]| -> Vec<f64> {
                        detector.reset();
                        let rows = r.chunks(channels).enumerate();
                        let all = rows.map(|(k, r)| detector.update(record.u(k), r).statistic);
                        all.skip(self.onset).collect()
                    };
                    let largest = healthy
                        .iter()
                        .zip(&quiet)
                        .map(|(record, r)| statistics(record, r).into_iter().fold(0.0, f64::max));
                    unit.healthy.push(largest.collect());
                    let Some(factors) = factors else {
                        continue;
                    };
                    let limit = factors[unit.healthy.len() - 1];
                    let mut delays = faulty.iter().zip(&loud).map(|(record, r)| {
                        statistics(record, r).iter().position(|&value| limit < value)
                    });
                    let per_fault = |fault: &Fault| {
                        delays.by_ref().take(fault.sizes.count()).collect::<Vec<_>>()
                    };
                    unit.found.push(self.faults.iter().map(per_fault).collect());
                }
            }
        }
        Ok(unit)
    }

    fn units(&self, from: u64, plants: u64, factors: Option<&[f64]>) -> Outcome<Vec<Unit>> {
        let one =
            |plant| self.unit(plant, factors).map_err(|error| format!("plant {plant}: {error}"));
        Ok((from..from + plants).into_par_iter().map(one).collect::<Result<_, String>>()?)
    }

    /// Runs the study with the arguments of the command line, `[plants] [first plant]`, and prints its tables.
    pub(crate) fn main(&self) -> Outcome<()> {
        let mut arguments = env::args().skip(1);
        let plants: u64 = arguments.next().map_or(Ok(20), |text| text.parse())?;
        let first: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
        let thresholds = self.units(first, plants, None)?;
        let entries = self.generators.len() * self.compensators.len() * DETECTORS.len();
        let factors: Vec<f64> = (0..entries)
            .map(|entry| {
                let mut all: Vec<f64> =
                    thresholds.iter().flat_map(|unit| unit.healthy[entry].clone()).collect();
                all.sort_by(f64::total_cmp);
                // The statistic that a share of the runs exceeds, on the safe side.
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a small count"
                )]
                let allowed = (FALSE_ALARMS * all.len() as f64).floor() as usize;
                all.get((all.len().max(1) - 1).saturating_sub(allowed)).copied().unwrap_or(0.0)
            })
            .collect();
        let test = self.units(first + plants, plants, Some(&factors))?;
        table::print(self, &factors, &test);
        Ok(())
    }
}
