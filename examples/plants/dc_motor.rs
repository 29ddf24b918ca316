//! A DC motor that differs from its model, as it does when it warms up: which residual finds which fault at the same
//! rate of false alarms, with and without compensation. Makes tables of `docs/results/plants.md`:
//!
//! ```text
//! cargo run -p fdiag --example dc_motor -- [plants] [first plant]
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

const MODEL: &str = include_str!("dc_motor.toml");
const TS_S: f64 = 2e-3;
const SAMPLES: usize = 2000;
const ONSET: usize = 1000;
/// Voltage about which the motor runs, and how far it jumps to either side.
const VOLTAGE: (f64, f64) = (50.0, 8.0);

const fn range(name: &'static str, unit: &'static str, smallest: f64, largest: f64) -> Fault {
    Fault { name, unit, sizes: Sizes::Range { smallest, largest, count: 8 } }
}

const FAULTS: [Fault; 7] = [
    range("voltage sensor gain", "share", 2e-3, 0.2),
    range("speed sensor offset", "rad/s", 0.1, 10.0),
    range("current sensor offset", "A", 0.01, 1.0),
    range("resistance", "Ω", 0.01, 1.0),
    range("flux", "share", 2e-3, 0.2),
    range("inertia", "share", 0.02, 2.0),
    range("viscous friction", "share", 0.05, 5.0),
];
/// The faulty parameter, and whether the size of the fault is a share of it.
const PARAMETERS: [Option<(&str, bool)>; 7] = [
    None,
    None,
    None,
    Some(("R_A", false)),
    Some(("Psi", true)),
    Some(("J", true)),
    Some(("M_F1", true)),
];

const GENERATORS: [(&str, &str); 9] = [
    ("simulation", "kind = 'simulation'"),
    ("observer", "kind = 'observer'\nrate = 20.0"),
    ("Kalman filter", "kind = 'kalman'\nprocess_noise = 1e-3\noutput_noise = 1e-2"),
    ("parity, order 2", "kind = 'parity'\norder = 2"),
    (
        "without the load",
        "kind = 'decoupled'\ndisturbance = { kind = 'directions', columns = [[0.0, 1.0]] }\nrate = 200.0",
    ),
    (
        "extended filter",
        "kind = 'extended'\nmodel.text = MODEL\nprocess_noise = { I_A = 5.0, omega = 5.0 }",
    ),
    ("nonlinear simulation", "kind = 'patched'\nmodel.text = MODEL"),
    ("parity from data, order 4", "kind = 'data-parity'\norder = 4\nstates = 2"),
    ("CVA, rest", "kind = 'cva'\npast = 5\nfuture = 5\nstates = 2"),
];

const COMPENSATORS: [(&str, &str); 3] = [
    ("no", "orders = { kind = 'fixed', na = 0, nb = 1, delay = 0, offset = true }"),
    (
        "linear",
        "orders = { kind = 'fixed', na = 2, nb = 3, delay = 0, offset = true }\n\
         learning = { kind = 'output-error' }",
    ),
    (
        "Hammerstein",
        "orders = { kind = 'fixed', na = 2, nb = 3, delay = 0, offset = true }\n\
         learning = { kind = 'output-error' }\n\
         structure = { kind = 'hammerstein', basis = { kind = 'polynomial', degree = 2 } }",
    ),
];

/// The parameters of one motor: each anywhere within its tolerance of the model.
fn motor(model: &Model, plant: u64) -> Vec<f64> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(plant);
    let mut draw =
        |value: f64, tolerance: f64| value * (1.0 + tolerance * random.random_range(-1.0..1.0));
    model.parameters.iter().map(|p| draw(p.value, p.tolerance)).collect()
}

fn run(plant: u64, seed: u64, fault: Option<(usize, f64)>) -> Outcome<Record> {
    let model: Model = MODEL.parse()?;
    let (theta, ts) = (motor(&model, plant), SampleTime::new(TS_S)?);
    let mut healthy = StateMap::new(&model, &theta, ts)?;
    let mut broken = theta;
    if let Some((kind, size)) = fault
        && let Some((name, relative)) = PARAMETERS[kind]
        && let Some(at) = model.parameters.iter().position(|p| p.name == name)
    {
        broken[at] += if relative { size * broken[at] } else { size };
    }
    let mut broken = StateMap::new(&model, &broken, ts)?;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut x, mut next, mut y) = (model.initial(), vec![0.0; 2], [0.0; 2]);
    for _ in 0..2000 {
        healthy.advance(1, &x, &[VOLTAGE.0], &[VOLTAGE.0], &mut next);
        x.copy_from_slice(&next);
    }
    let (mut u, mut until) = (VOLTAGE.0, 0);
    let (mut us, mut ys) = (Vec::new(), Vec::new());
    for k in 0..SAMPLES {
        // Levels that hold for a pseudo-random time. The published runs have two levels; those leave nothing of the
        // second degree to learn.
        if until <= k {
            u = VOLTAGE.0 + VOLTAGE.1 * random.random_range(-1.0..1.0);
            until = k + random.random_range(10..60);
        }
        let map = if ONSET <= k { &mut broken } else { &mut healthy };
        map.output(k as u64, &x, &[u], &mut y);
        map.advance(k as u64, &x, &[u], &[u], &mut next);
        x.copy_from_slice(&next);
        let of = |wanted: usize| match fault {
            Some((kind, size)) if kind == wanted && ONSET <= k => size,
            _ => 0.0,
        };
        us.push(u * (1.0 + of(0)));
        let mut noise = || (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
        ys.push(y[0] + 0.05 * noise() + of(2));
        ys.push(y[1] + 0.5 * noise() + of(1));
    }
    let inputs = vec![Channel::new("U_A", "V")];
    let outputs = vec![Channel::new("current", "A"), Channel::new("speed", "rad/s")];
    Ok(Record::new(inputs, outputs, us, ys, ts)?)
}

fn main() -> Outcome<()> {
    let model: Model = MODEL.parse()?;
    let mut map = StateMap::new(&model, &model.nominal(), SampleTime::new(TS_S)?)?;
    let (mut x, mut next) = (model.initial(), vec![0.0; 2]);
    for _ in 0..2000 {
        map.advance(1, &x, &[VOLTAGE.0], &[VOLTAGE.0], &mut next);
        x.copy_from_slice(&next);
    }
    let study = Study {
        model: MODEL,
        ts_s: TS_S,
        onset: ONSET,
        settle_s: 0.4,
        faults: &FAULTS,
        generators: &GENERATORS,
        compensators: &COMPENSATORS,
        at: OperatingPoint {
            x: x.clone(),
            u: vec![VOLTAGE.0],
            dx: vec![0.5, 5.0],
            du: vec![VOLTAGE.1],
        },
        y: x,
        dy: vec![0.5, 5.0],
        run: &run,
    };
    study.main()
}
