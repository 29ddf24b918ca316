//! Three tanks that differ from their model: which residual finds which fault at the same rate of false alarms,
//! with and without compensation. Makes the tables of `docs/results/plants.md`:
//!
//! ```text
//! cargo run -p fdiag --example three_tanks -- [plants] [first seed]
//! ```
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::{env, error::Error};

use fdiag::{
    model::{Channel, ChannelScale, Record, SampleTime, Scaling, figure},
    nonlinear::{OperatingPoint, linearise},
    sim::{model::Model, simulate::StateMap},
    spec::{NominalPlant, PipelineSpec},
    training::train_on,
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

const MODEL: &str = include_str!("three_tanks.toml");
const TS_S: f64 = 2.0;
const SAMPLES: usize = 1000;
const ONSET: usize = 500;
/// Runs of a plant for the scale of its detectors, and for thresholds or results.
const CALIBRATION: u64 = 4;
const RUNS: u64 = 5;
/// Share of fault-free runs that may alarm.
const FALSE_ALARMS: f64 = 0.05;
const REST: ([f64; 2], [f64; 3]) = ([39.4, 13.0], [45.0, 15.0, 29.7]);

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Faults by name, with the unit of their size, the smallest and the largest size in it.
const FAULTS: [(&str, &str, [f64; 2]); 7] = [
    ("leak of tank 1", "cm² of opening", [1e-3, 0.1]),
    ("leak of tank 3", "cm² of opening", [1e-3, 0.1]),
    ("plugging between 1 and 3", "share", [3e-3, 0.3]),
    ("plugging of the outflow", "share", [3e-3, 0.3]),
    ("pump 1 loses", "share", [3e-3, 0.3]),
    ("sensor 1 offset", "cm", [0.05, 5.0]),
    ("sensor 3 gain", "share", [2e-3, 0.2]),
];
/// Sizes of a fault, spaced evenly in the logarithm.
const SIZES: usize = 8;

fn size(fault: usize, at: f64) -> f64 {
    let [smallest, largest] = FAULTS[fault].2;
    smallest * (largest / smallest).powf(at / (SIZES - 1) as f64)
}

/// Generators by name, each with its line of a spec.
const GENERATORS: [(&str, &str); 8] = [
    ("simulation", "kind = 'simulation'"),
    ("observer", "kind = 'observer'\nrate = 0.05"),
    ("Kalman filter", "kind = 'kalman'\nprocess_noise = 1e-3\noutput_noise = 1e-2"),
    ("parity, order 3", "kind = 'parity'\norder = 3"),
    (
        "extended filter",
        "kind = 'extended'\nmodel.text = MODEL\nprocess_noise = { h_1 = 0.02, h_2 = 0.02, h_3 = 0.02 }",
    ),
    ("nonlinear simulation", "kind = 'patched'\nmodel.text = MODEL"),
    ("parity from data, order 5", "kind = 'data-parity'\norder = 5\nstates = 3"),
    ("CVA, rest", "kind = 'cva'\npast = 5\nfuture = 5\nstates = 3"),
];

/// One plant.
struct Tanks {
    resistance: [f64; 3],
    area: f64,
    pumps: [f64; 2],
}

impl Tanks {
    /// Flow coefficients within 5 %, pumps within 3 %, areas within 1 % of the model.
    fn draw(random: &mut Xoshiro256PlusPlus) -> Self {
        let mut about =
            |value: f64, share: f64| value * (1.0 + share * random.random_range(-1.0..1.0));
        Self {
            resistance: [about(0.46, 0.05), about(0.60, 0.05), about(0.45, 0.05)],
            area: about(154.0, 0.01),
            pumps: [about(1.0, 0.03), about(1.0, 0.03)],
        }
    }

    fn rates(&self, h: [f64; 3], u: [f64; 2], fault: Option<(usize, f64)>) -> [f64; 3] {
        let of = |wanted: usize| {
            fault.map_or(0.0, |(kind, size)| if kind == wanted { size } else { 0.0 })
        };
        let root = |drop: f64| (2.0 * 981.0 * drop.abs()).sqrt().copysign(drop);
        let [a_1, a_2, a_3] = self.resistance;
        let q_13 = a_1 * 0.5 * (1.0 - of(2)) * root(h[0] - h[2]);
        let q_32 = a_3 * 0.5 * root(h[2] - h[1]);
        let q_20 = a_2 * 0.5 * (1.0 - of(3)) * root(h[1].max(0.0));
        let pumped = [self.pumps[0] * (1.0 - of(4)) * u[0], self.pumps[1] * u[1]];
        [
            (pumped[0] - q_13 - of(0) * root(h[0].max(0.0))) / self.area,
            (pumped[1] + q_32 - q_20) / self.area,
            (q_13 - q_32 - of(1) * root(h[2].max(0.0))) / self.area,
        ]
    }

    /// A run about the operating point from where this plant rests; the pumps change level every one to five
    /// minutes. A fault begins at [`ONSET`] and stays.
    fn run(&self, seed: u64, fault: Option<(usize, f64)>) -> Outcome<Record> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut h = REST.1;
        let step = |h: &mut [f64; 3], u, fault| {
            let at = |k: [f64; 3], by: f64| [0, 1, 2].map(|i| h[i] + by * k[i]);
            let k_1 = self.rates(*h, u, fault);
            let k_2 = self.rates(at(k_1, 0.5), u, fault);
            let k_3 = self.rates(at(k_2, 0.5), u, fault);
            let k_4 = self.rates(at(k_3, 1.0), u, fault);
            *h = [0, 1, 2].map(|i| h[i] + (k_1[i] + 2.0 * k_2[i] + 2.0 * k_3[i] + k_4[i]) / 6.0);
        };
        // The longest time constant is some 500 s.
        (0..3000).for_each(|_| step(&mut h, REST.0, None));
        let (mut u, mut until) = (REST.0, [0, 0]);
        let (mut us, mut ys) = (Vec::new(), Vec::new());
        for k in 0..SAMPLES {
            for i in 0..2 {
                if until[i] <= k {
                    u[i] = REST.0[i] * (1.0 + 0.25 * random.random_range(-1.0..1.0));
                    until[i] = k + random.random_range(30..150);
                }
            }
            let fault = fault.filter(|_| ONSET <= k);
            us.extend(u);
            for (i, level) in h.iter().enumerate() {
                let noise = 0.1 * (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
                let sensor = match fault {
                    Some((5, size)) if i == 0 => size,
                    Some((6, size)) if i == 2 => size * level,
                    _ => 0.0,
                };
                ys.push(level + noise + sensor);
            }
            (0..2).for_each(|_| step(&mut h, u, fault));
        }
        let inputs = ["Q_1", "Q_2"].map(|name| Channel::new(name, "cm^3/s")).to_vec();
        let outputs =
            ["level_1", "level_2", "level_3"].map(|name| Channel::new(name, "cm")).to_vec();
        Ok(Record::new(inputs, outputs, us, ys, SampleTime::new(TS_S)?)?)
    }
}

fn scaling() -> Scaling {
    Scaling {
        inputs: REST.0.map(|u| ChannelScale::per_unit(u, 10.0)).to_vec(),
        outputs: REST.1.map(|h| ChannelScale::per_unit(h, 1.0)).to_vec(),
    }
}

/// Without and with compensation.
const WAYS: [&str; 2] = ["no", "yes"];

/// What one plant gave: per generator and way the largest statistic of healthy runs, and per fault and size that of
/// faulty ones.
#[derive(Default)]
struct Unit {
    healthy: Vec<Vec<f64>>,
    faulty: Vec<Vec<Vec<f64>>>,
}

fn unit(seed: u64, with_faults: bool) -> Outcome<Unit> {
    let plant = Tanks::draw(&mut Xoshiro256PlusPlus::seed_from_u64(seed));
    let scaling = scaling();
    let run = |purpose: u64, fault| -> Outcome<Record> {
        Ok(plant.run(1_000_000 * seed + purpose, fault)?.scaled(&scaling)?)
    };
    let model: Model = MODEL.parse()?;
    let ts = SampleTime::new(TS_S)?;
    let at = OperatingPoint {
        x: REST.1.to_vec(),
        u: REST.0.to_vec(),
        dx: vec![1.0; 3],
        du: vec![1.0; 2],
    };
    let physical = linearise(&StateMap::new(&model, &model.nominal(), ts)?, &at, ts)?;
    let system = fdiag::model::StateSpace::new(
        physical.a().to_owned(),
        physical.b() * faer::Scale(10.0),
        physical.c().to_owned(),
        physical.d() * faer::Scale(10.0),
        physical.domain(),
    )?;
    let training = run(0, None)?;
    let calibration = (1..=CALIBRATION).map(|i| run(i, None)).collect::<Outcome<Vec<_>>>()?;
    let healthy = (10..10 + RUNS).map(|i| run(i, None)).collect::<Outcome<Vec<_>>>()?;
    let mut faulty = Vec::new();
    if with_faults {
        for kind in 0..FAULTS.len() {
            for i in 0..SIZES {
                // The same inputs and noise as the first healthy run.
                faulty.push(run(10, Some((kind, size(kind, i as f64))))?);
            }
        }
    }
    let mut unit = Unit::default();
    for (name, line) in GENERATORS {
        let text = format!(
            "settle_s = 200.0\n[generator]\n{}\n[bias]\n\
             orders = {{ kind = 'fixed', na = 2, nb = 3, delay = 0, offset = true }}\n\
             learning = {{ kind = 'output-error' }}\n[detector]\nkind = 'chi-square'\nwindow = 20\n\
             false_alarms = {{ kind = 'per-run', probability = 0.05, samples = 1000 }}\n",
            line.replace("MODEL", &format!("'''\n{MODEL}'''")),
        );
        let spec: PipelineSpec = toml::from_str(&text).map_err(|e| format!("{name}: {e}"))?;
        let plant = NominalPlant::from(&system).in_units(scaling.clone());
        let trained =
            train_on(&spec, plant, &training, &calibration).map_err(|e| format!("{name}: {e}"))?;
        for way in 0..WAYS.len() {
            let scale = if way == 0 { trained.calibration().0 } else { trained.calibration().1 };
            let mut detector = trained.scaled(&spec.detector, scale)?;
            let (mut primary, mut subtraction) = (trained.primary()?, trained.subtraction()?);
            let channels = trained.design().residual_len();
            let mut largest = |records: &[Record], from: usize| -> Outcome<Vec<f64>> {
                let mut all = Vec::new();
                for record in records {
                    let mut r = primary.whole(record, from)?;
                    if way == 1 {
                        r = subtraction.of(record, &r)?.residual;
                    }
                    detector.reset();
                    let rows = r.chunks(channels).enumerate();
                    let statistics = rows.map(|(k, r)| detector.update(record.u(k), r).statistic);
                    all.push(statistics.skip(from).fold(0.0, f64::max));
                }
                Ok(all)
            };
            // The second half in either case: as many samples may alarm by chance as with a fault.
            unit.healthy.push(largest(&healthy, ONSET)?);
            let all = largest(&faulty, ONSET)?;
            unit.faulty.push(all.chunks(SIZES).map(<[f64]>::to_vec).collect());
        }
    }
    Ok(unit)
}

fn main() -> Outcome<()> {
    let mut arguments = env::args().skip(1);
    let plants: u64 = arguments.next().map_or(Ok(20), |text| text.parse())?;
    let first: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let study = |from: u64, with_faults| -> Outcome<Vec<Unit>> {
        let one = |seed| unit(seed, with_faults).map_err(|error| format!("plant {seed}: {error}"));
        Ok((from..from + plants).into_par_iter().map(one).collect::<Result<_, String>>()?)
    };
    let thresholds = study(first, false)?;
    let test = study(first + plants, true)?;
    let names: Vec<String> =
        FAULTS.iter().map(|(name, unit, _)| format!("{name} [{unit}]")).collect();
    println!("| residual | compensated | false alarms [%] | {} |", names.join(" | "));
    println!("|---|---|---|{}", "---|".repeat(names.len()));
    for (entry, (name, way)) in
        GENERATORS.iter().flat_map(|(name, _)| WAYS.map(|way| (name, way))).enumerate()
    {
        let mut all: Vec<f64> =
            thresholds.iter().flat_map(|unit| unit.healthy[entry].clone()).collect();
        all.sort_by(f64::total_cmp);
        // The factor that a share of the runs exceeds, on the safe side.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small count"
        )]
        let allowed = (FALSE_ALARMS * all.len() as f64).floor() as usize;
        let factor = all[all.len() - 1 - allowed];
        let over = |values: &[f64]| {
            100.0 * values.iter().filter(|&&value| value > factor).count() as f64 / RUNS as f64
        };
        let alarms: Vec<f64> = test.iter().map(|unit| over(&unit.healthy[entry])).collect();
        let cells: Vec<String> = (0..FAULTS.len())
            .map(|fault| {
                let of = |unit: &Unit| -> Vec<bool> {
                    unit.faulty[entry][fault].iter().map(|&value| value > factor).collect()
                };
                half(fault, &test.iter().map(of).collect::<Vec<_>>())
            })
            .collect();
        println!("| {name} | {way} | {} | {} |", interval(&alarms), cells.join(" | "));
    }
    Ok(())
}

/// Mean over plants and twice its standard error, in per cent; runs of one plant are not independent.
fn interval(shares: &[f64]) -> String {
    let n = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / n;
    let square = shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>();
    format!("{mean:.1} ± {:.1}", 2.0 * (square / (n * (n - 1.0))).sqrt())
}

/// The size that is found on half of the plants, interpolated in the logarithm, with the interval in which it lies
/// for 95 of 100 draws of as many plants.
fn half(fault: usize, found: &[Vec<bool>]) -> String {
    let crossing = |plants: &[usize]| -> f64 {
        let share = |i: usize| {
            plants.iter().filter(|&&plant| found[plant][i]).count() as f64 / plants.len() as f64
        };
        // The last size that is found on less than half.
        match (0..SIZES).rev().find(|&i| share(i) < 0.5) {
            None => 0.0,
            Some(i) if i + 1 == SIZES => f64::INFINITY,
            Some(i) => i as f64 + (0.5 - share(i)) / (share(i + 1) - share(i)),
        }
    };
    let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
    let mut drawn: Vec<f64> = (0..400)
        .map(|_| {
            let plants: Vec<usize> =
                (0..found.len()).map(|_| random.random_range(0..found.len())).collect();
            crossing(&plants)
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    let words = |at: f64| match at {
        at if at <= 0.0 => format!("< {}", size(fault, 0.0)),
        at if at.is_infinite() => format!("> {}", size(fault, (SIZES - 1) as f64)),
        at => figure(size(fault, at)),
    };
    let all: Vec<usize> = (0..found.len()).collect();
    format!("{} [{} .. {}]", words(crossing(&all)), words(drawn[10]), words(drawn[389]))
}
