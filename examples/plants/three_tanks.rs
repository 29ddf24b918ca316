//! Three tanks that differ from their model: which residual finds which fault at the same rate of false alarms,
//! with and without compensation. Makes tables of `docs/results/plants.md`:
//!
//! ```text
//! cargo run -p fdiag --example three_tanks -- [plants] [first plant]
//! ```

mod study;

use fdiag::{
    model::{Channel, Record, SampleTime},
    nonlinear::OperatingPoint,
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use study::{Fault, Outcome, Sizes, Study};

const MODEL: &str = include_str!("three_tanks.toml");
const TS_S: f64 = 2.0;
const SAMPLES: usize = 1000;
const ONSET: usize = 500;
const REST: ([f64; 2], [f64; 3]) = ([39.4, 13.0], [45.0, 15.0, 29.7]);

const fn range(name: &'static str, unit: &'static str, smallest: f64, largest: f64) -> Fault {
    Fault { name, unit, sizes: Sizes::Range { smallest, largest, count: 8 } }
}

const FAULTS: [Fault; 7] = [
    range("leak of tank 1", "cm² of opening", 1e-3, 0.1),
    range("leak of tank 3", "cm² of opening", 1e-3, 0.1),
    range("plugging between 1 and 3", "share", 3e-3, 0.3),
    range("plugging of the outflow", "share", 3e-3, 0.3),
    range("pump 1 loses", "share", 3e-3, 0.3),
    range("sensor 1 offset", "cm", 0.05, 5.0),
    range("sensor 3 gain", "share", 2e-3, 0.2),
];

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

const COMPENSATORS: [(&str, &str); 2] = [
    ("no", "orders = { kind = 'fixed', na = 0, nb = 1, delay = 0, offset = true }"),
    (
        "linear",
        "orders = { kind = 'fixed', na = 2, nb = 3, delay = 0, offset = true }\n\
         learning = { kind = 'output-error' }",
    ),
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

fn main() -> Outcome<()> {
    let run = |plant: u64, seed: u64, fault| {
        Tanks::draw(&mut Xoshiro256PlusPlus::seed_from_u64(plant)).run(seed, fault)
    };
    let study = Study {
        model: MODEL,
        ts_s: TS_S,
        onset: ONSET,
        settle_s: 200.0,
        faults: &FAULTS,
        generators: &GENERATORS,
        compensators: &COMPENSATORS,
        at: OperatingPoint {
            x: REST.1.to_vec(),
            u: REST.0.to_vec(),
            dx: vec![1.0; 3],
            du: vec![10.0; 2],
        },
        y: REST.1.to_vec(),
        dy: vec![1.0; 3],
        run: &run,
    };
    study.main()
}
