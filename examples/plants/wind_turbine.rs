//! A wind turbine in full load that differs from its model, with the faults of the benchmark of Odgaard, Stoustrup and
//! Kinnaert: which residual finds which at the same rate of false alarms, with and without compensation. Makes tables of
//! `docs/results/plants.md`:
//!
//! ```text
//! cargo run -p fdiag --example wind_turbine -- [plants] [first plant]
//! ```

mod study;

use fdiag::{
    model::{Channel, Record, SampleTime},
    nonlinear::OperatingPoint,
    sim::{model::Model, simulate::StateMap},
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use study::{Fault, Outcome, Sizes, Study};

const MODEL: &str = include_str!("wind_turbine.toml");
const TS_S: f64 = 0.05;
const SAMPLES: usize = 4000;
const ONSET: usize = 2000;
/// Mean wind, its standard deviation, and the memory of a gust: in m/s and s.
const WIND: (f64, f64, f64) = (17.0, 1.2, 20.0);
/// Standard deviations of the sensors: of the outputs, and of the wind in m/s.
const NOISE: ([f64; 12], f64) =
    ([0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.025, 0.025, 0.05, 0.05, 90.0, 1000.0], 0.5);
/// Samples over which the third pitch system becomes slow, and steps of it.
const RAMP: (usize, usize) = (600, 12);

const fn published(name: &'static str) -> Fault {
    Fault { name, unit: "", sizes: Sizes::Published }
}

const FAULTS: [Fault; 9] = [
    published("1: pitch sensor 1 of blade 1 stuck at 5°"),
    published("2: pitch sensor 2 of blade 2 times 1.2"),
    published("3: pitch sensor 1 of blade 3 stuck at 10°"),
    published("4: rotor speed sensor 1 stuck at 1.4 rad/s"),
    published("5: rotor speed sensor 2 times 1.1 and generator speed sensor 2 times 0.9"),
    published("6: pitch system 2 at low pressure"),
    published("7: pitch system 3 with air in the oil, in 30 s"),
    published("8: converter off by 100 N m"),
    published("9: drive train efficiency 0.92"),
];

const GENERATORS: [(&str, &str); 9] = [
    ("simulation", "kind = 'simulation'"),
    ("Kalman filter, slow", "kind = 'kalman'\nprocess_noise = 1e-4\noutput_noise = 1e-1"),
    ("Kalman filter, fast", "kind = 'kalman'\nprocess_noise = 1e-2\noutput_noise = 1e-1"),
    ("parity, order 1", "kind = 'parity'\norder = 1"),
    (
        "without the wind",
        "kind = 'decoupled'\ndisturbance = { kind = 'learned', rank = 1 }\nrate = 1.0",
    ),
    (
        "extended filter",
        "kind = 'extended'\nmodel.text = MODEL\n\
         process_noise = { b_1 = 0.05, c_1 = 5.0, b_2 = 0.05, c_2 = 5.0, b_3 = 0.05, c_3 = 5.0, \
         w_r = 2e-3, w_g = 0.02, twist = 1e-6, tau_g = 50.0 }\n\
         initial = { c_1 = 1.0, c_2 = 1.0, c_3 = 1.0 }",
    ),
    ("nonlinear simulation", "kind = 'patched'\nmodel.text = MODEL"),
    ("parity from data, order 3", "kind = 'data-parity'\norder = 3\nstates = 10"),
    ("CVA, rest", "kind = 'cva'\npast = 3\nfuture = 3\nstates = 10"),
];

const COMPENSATORS: [(&str, &str); 2] = [
    ("no", "orders = { kind = 'fixed', na = 0, nb = 1, delay = 0, offset = true }"),
    (
        "linear",
        "orders = { kind = 'fixed', na = 2, nb = 3, delay = 0, offset = true }\n\
         learning = { kind = 'output-error' }",
    ),
];

/// The model with an error `e_1` to `e_3` on the reference of each blade.
fn bladed() -> Outcome<Model> {
    let mut text = MODEL.replace(
        "v = { unit = \"m/s\" }",
        "v = { unit = \"m/s\" }\ne_1 = { unit = \"deg\" }\ne_2 = { unit = \"deg\" }\ne_3 = { unit = \"deg\" }",
    );
    for blade in 1..=3 {
        text = text.replace(
            &format!("(beta_r - b_{blade})"),
            &format!("(beta_r + e_{blade} - b_{blade})"),
        );
    }
    Ok(text.parse()?)
}

/// The parameters of one turbine: each anywhere within its tolerance of the model.
fn turbine(model: &Model, plant: u64) -> Vec<f64> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(plant);
    let mut draw =
        |value: f64, tolerance: f64| value * (1.0 + tolerance * random.random_range(-1.0..1.0));
    model.parameters.iter().map(|p| draw(p.value, p.tolerance)).collect()
}

/// The parameters with a fault: all of it, or a part of what comes slowly.
fn with_fault(model: &Model, healthy: &[f64], fault: usize, part: f64) -> Vec<f64> {
    let mut theta = healthy.to_vec();
    let mut towards = |name: &str, value: f64| {
        if let Some(at) = model.parameters.iter().position(|p| p.name == name) {
            theta[at] += part * (value - theta[at]);
        }
    };
    match fault {
        5 => {
            towards("zeta_2", 0.45);
            towards("omega_2", 5.73);
        }
        6 => {
            towards("zeta_3", 0.9);
            towards("omega_3", 3.42);
        }
        7 => towards("lost", 100.0),
        8 => towards("eta_dt", 0.92),
        _ => {}
    }
    theta
}

/// What sensor faults make of the outputs.
fn mistaken(y: &mut [f64], fault: usize) {
    match fault {
        0 => y[0] = 5.0,
        1 => y[3] *= 1.2,
        2 => y[4] = 10.0,
        3 => y[6] = 1.4,
        4 => {
            y[7] *= 1.1;
            y[9] *= 0.9;
        }
        _ => {}
    }
}

/// The published controller of full load: constant power, and the pitch by a digital PI controller.
struct Controller {
    pitch: f64,
    error: f64,
}

impl Controller {
    /// References for the pitch and the torque, from the mean of the two speed sensors.
    fn step(&mut self, speed: f64) -> [f64; 2] {
        let (k_p, k_i) = (4.0, 1.0);
        let error = speed - 162.0;
        self.pitch += k_p * error + (k_i * TS_S - k_p) * self.error;
        self.pitch = self.pitch.clamp(0.0, 90.0);
        self.error = error;
        [self.pitch, 4.8e6 / (0.98 * speed)]
    }
}

fn run(plant: u64, seed: u64, fault: Option<(usize, f64)>) -> Outcome<Record> {
    let (model, ts) = (bladed()?, SampleTime::new(TS_S)?);
    let theta = turbine(&model, plant);
    let mut healthy = StateMap::new(&model, &theta, ts)?;
    let steps = fault.map_or(0, |(kind, _)| if kind == 6 { RAMP.1 } else { 1 });
    let mut broken = Vec::new();
    for step in 1..=steps {
        let kind = fault.map_or(0, |(kind, _)| kind);
        let theta = with_fault(&model, &theta, kind, step as f64 / steps as f64);
        broken.push(StateMap::new(&model, &theta, ts)?);
    }
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut noise = || (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
    let (mut x, mut next, mut y) = (model.initial(), vec![0.0; 10], [0.0; 12]);
    let mut controller = Controller { pitch: x[0], error: 0.0 };
    let (mut gust, memory) = (0.0, (-TS_S / WIND.2).exp());
    let (mut us, mut ys) = (Vec::new(), Vec::new());
    // The turbine finds its rest before the record begins.
    let before = 2000;
    for k in 0..before + SAMPLES {
        let is_faulty = before + ONSET <= k && fault.is_some();
        let past = k.saturating_sub(before + ONSET) * broken.len().max(1);
        let step = (past / RAMP.0).min(broken.len().saturating_sub(1));
        let map = if is_faulty { &mut broken[step] } else { &mut healthy };
        // Below 13.5 m/s the turbine would leave full load.
        let wind = (WIND.0 + gust).max(13.5);
        gust = memory * gust + (1.0 - memory * memory).sqrt() * WIND.1 * noise();
        let still = [0.0; 6];
        map.output(1, &x, &still, &mut y);
        for (y, deviation) in y.iter_mut().zip(NOISE.0) {
            *y += deviation * noise();
        }
        if let Some((kind, _)) = fault.filter(|_| is_faulty) {
            mistaken(&mut y, kind);
        }
        let [pitch, torque] = controller.step(0.5 * (y[8] + y[9]));
        if before <= k {
            us.extend([pitch, torque, wind + NOISE.1 * noise()]);
            ys.extend(y);
        }
        // Each pitch system holds its own mean of two sensors at the reference.
        let off = |blade: usize| x[2 * blade] - 0.5 * (y[2 * blade] + y[2 * blade + 1]);
        let u = [pitch, torque, wind, off(0), off(1), off(2)];
        map.advance(1, &x, &u, &u, &mut next);
        x.copy_from_slice(&next);
    }
    let channels = |all: &[Channel]| all.to_vec();
    Ok(Record::new(channels(&healthy.inputs()[..3]), channels(healthy.outputs()), us, ys, ts)?)
}

/// State, inputs and outputs of the nominal turbine in a steady wind.
fn rest() -> Outcome<[Vec<f64>; 3]> {
    let model: Model = MODEL.parse()?;
    let mut map = StateMap::new(&model, &model.nominal(), SampleTime::new(TS_S)?)?;
    let (mut x, mut next, mut y) = (model.initial(), vec![0.0; 10], vec![0.0; 12]);
    let mut controller = Controller { pitch: x[0], error: 0.0 };
    let mut u = vec![x[0], x[9], WIND.0];
    for _ in 0..10_000 {
        map.output(1, &x, &u, &mut y);
        let [pitch, torque] = controller.step(y[8]);
        u = vec![pitch, torque, WIND.0];
        map.advance(1, &x, &u, &u, &mut next);
        x.copy_from_slice(&next);
    }
    Ok([x, u, y])
}

fn main() -> Outcome<()> {
    let [x, u, y] = rest()?;
    let study = Study {
        model: MODEL,
        ts_s: TS_S,
        onset: ONSET,
        settle_s: 30.0,
        faults: &FAULTS,
        generators: &GENERATORS,
        compensators: &COMPENSATORS,
        at: OperatingPoint {
            x,
            u,
            dx: vec![1.0, 5.0, 1.0, 5.0, 1.0, 5.0, 0.02, 2.0, 1e-4, 500.0],
            du: vec![1.0, 500.0, 1.0],
        },
        y,
        dy: vec![1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.02, 0.02, 2.0, 2.0, 500.0, 1e4],
        run: &run,
    };
    study.main()
}
