//! Effects that people's systems have: a parameter that follows a column of the log, an event at an unknown time, an elastic
//! transmission. Six cases of each, simulated by the equations of this file, a hundred times finer than sampled.

use fd_effect::{EverySite, SiteRef, library};
use fd_gap::diagnose::{Case, Diagnosis, Settings, diagnose};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::{model::Model, scales::ReplayScales};

/// Rates of the states of a real system, from time, states and inputs.
type Rates = Box<dyn Fn(f64, &[f64], &[f64]) -> Vec<f64>>;
/// What is measured of the states.
type Shown = fn(&[f64]) -> f64;

/// A real system and what its owner believes.
pub(crate) struct System {
    name: &'static str,
    model: String,
    rates: Rates,
    shown: Shown,
    states: usize,
    inputs: Vec<Vec<f64>>,
    noise: f64,
    /// Label and place of what the model lacks.
    truth: (&'static str, &'static str),
}

/// Pseudo-random numbers in [-1, 1) (Knuth's linear congruence).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / 2.0_f64.powi(53) * 2.0 - 1.0
    }
}

/// Levels that change every so often.
fn stairs(seed: u64, samples: usize, (middle, swing): (f64, f64), length: usize) -> Vec<f64> {
    let (mut dice, mut level) = (Dice(seed), middle);
    let each = (0..samples).map(|k| {
        if k.is_multiple_of(length) {
            level = middle + swing * dice.roll();
        }
        level
    });
    each.collect()
}

/// What changes slowly, as a temperature does.
fn slow(seed: u64, samples: usize, middle: f64, swing: f64) -> Vec<f64> {
    let mut dice = Dice(seed);
    let phases: Vec<f64> = (0..4).map(|_| 3.2 * dice.roll()).collect();
    let each = (0..samples).map(|k| {
        let x = k as f64 / samples as f64;
        let waves = phases.iter().enumerate().map(|(i, p)| (6.3 * x * (i + 1) as f64 + p).sin());
        middle + 0.4 * swing * waves.sum::<f64>()
    });
    each.collect()
}

impl System {
    fn record(&self, model: &Model, seed: u64) -> Record {
        let (ts, fine) = (model.sample_time, 100);
        let samples = self.inputs[0].len();
        let noise = WhiteNoise::new(self.noise, seed).values(samples).unwrap();
        let mut x = vec![0.0; self.states];
        let h = ts / f64::from(fine);
        let rows = (0..samples).map(|k| {
            let u: Vec<f64> = self.inputs.iter().map(|input| input[k]).collect();
            let y = [(self.shown)(&x) + noise[k]];
            for i in 0..fine {
                let t = ts * k as f64 + h * f64::from(i);
                // Heun's method: of the error of a step of a hundredth of a sample nothing is seen.
                let first = (self.rates)(t, &x, &u);
                let there: Vec<f64> = x.iter().zip(&first).map(|(x, r)| x + h * r).collect();
                let second = (self.rates)(t + h, &there, &u);
                for ((x, a), b) in x.iter_mut().zip(first).zip(second) {
                    *x += 0.5 * h * (a + b);
                }
            }
            (u, y)
        });
        let rows: Vec<(Vec<f64>, [f64; 1])> = rows.collect();
        let ts = model.sample_time().unwrap();
        Record::from_rows(model.external_inputs(), model.output_channels(), rows, ts).unwrap()
    }

    fn diagnosis(&self) -> Diagnosis {
        let model: Model = self.model.parse().unwrap();
        let log = self.record(&model, 11);
        let u: Vec<f64> = (0..log.len()).flat_map(|k| log.u(k).to_vec()).collect();
        let cut = 2 * log.len() / 3;
        let (fit, later) = (log.slice(0, cut), log.slice(cut, log.len()));
        let width = model.external_inputs().len();
        let scales =
            ReplayScales::of(&model, model.sample_time().unwrap(), &u[..cut * width], cut).unwrap();
        let suspects = EverySite::new(library(), &model, scales);
        let (logs, held_out) = ([fit], [later]);
        let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
        diagnose(&case, &Settings::default(), &()).unwrap()
    }

    /// Whether the cause is named, or is one of those that the log cannot tell from the named one; and what is said.
    pub(crate) fn is_found(&self) -> (bool, String) {
        let found = self.diagnosis();
        let name = |site: &SiteRef| site.name().unwrap_or_default().to_owned();
        let is_it = |label: &str, site: &SiteRef| (label, name(site).as_str()) == self.truth;
        let first = found.causes.first();
        let named = first.is_some_and(|c| is_it(c.label, &c.site));
        let tied = found.tied.iter().filter_map(|id| found.cause(*id));
        let tied = tied.into_iter().any(|c| is_it(c.label, &c.site));
        let all = found.causes.iter().take(4).map(|c| {
            let values: Vec<String> =
                c.parameters.iter().map(|p| format!("{:.3}", p.value)).collect();
            format!(
                "{} {} at {} p {:.2} Z {:.0} {}",
                c.label,
                c.law,
                name(&c.site),
                c.probability,
                c.log_evidence,
                values.join(" ")
            )
        });
        let said = format!(
            "{}: {:?}, no gap {:.2}, {}",
            self.name,
            found.verdict,
            found.no_gap,
            all.collect::<Vec<_>>().join("; ")
        );
        (named || tied, said)
    }
}

const ROOM: &str = r#"
version = 1
kind = "equations"
name = "room"
sample_time = 30.0
[parameters]
R = { unit = "K/W", value = 0.02, tolerance = 0.1 }
C = { unit = "J/K", value = 1e5, tolerance = 0.05 }
[inputs]
heat = { unit = "W" }
fan = { unit = "1/s" }
[states]
T = { unit = "K", initial = 0.0, derivative = "(heat - T/R)/C" }
[outputs]
T_m = { unit = "K", value = "T", noise = 0.05 }
[sites]
air = { unit = "W", enters = { T = "1/C" } }
"#;

const CART: &str = r#"
version = 1
kind = "equations"
name = "cart"
sample_time = 0.02
[parameters]
m = { unit = "kg", value = 2.0, tolerance = 0.03 }
d = { unit = "N s/m", value = 1.5, tolerance = 0.1 }
[inputs]
force = { unit = "N" }
oil = { unit = "K" }
[states]
v = { unit = "m/s", initial = 0.0, derivative = "(force - d*v)/m" }
[outputs]
speed = { unit = "m/s", value = "v", noise = 0.004 }
[sites]
rail = { unit = "N", enters = { v = "1/m" }, velocity = "v" }
"#;

const ARM: &str = r#"
version = 1
kind = "equations"
name = "arm"
sample_time = 0.01
[parameters]
J = { unit = "kg m^2", value = 0.05, tolerance = 0.05 }
d = { unit = "N m s/rad", value = 0.05, tolerance = 0.3 }
k = { unit = "N m/rad", value = 0.4, tolerance = 0.05 }
[inputs]
tau = { unit = "N m" }
[states]
q = { unit = "rad", initial = 0.0, derivative = "w" }
w = { unit = "rad/s", initial = 0.0, derivative = "(tau - d*w - k*q)/J" }
[outputs]
angle = { unit = "rad", value = "q", noise = 0.001 }
[sites]
joint = { unit = "N m", enters = { w = "1/J" }, position = "q", velocity = "w" }
"#;

/// A room whose resistance to the outside is a function of time and fan.
fn room(name: &'static str, label: &'static str, r: impl Fn(f64, f64) -> f64 + 'static) -> System {
    let n = 900;
    System {
        name,
        model: ROOM.to_owned(),
        rates: Box::new(move |t, x, u| vec![(u[0] - x[0] / r(t, u[1])) / 1.02e5]),
        shown: |x| x[0],
        states: 1,
        inputs: vec![stairs(5, n, (500.0, 400.0), 60), slow(6, n, 1.0, 0.6)],
        noise: 0.05,
        truth: (label, "R"),
    }
}

/// A cart whose mass or drag is a function of time and temperature.
fn cart(
    name: &'static str,
    truth: (&'static str, &'static str),
    of: impl Fn(f64, f64) -> (f64, f64) + 'static,
) -> System {
    let n = 1200;
    System {
        name,
        model: CART.to_owned(),
        rates: Box::new(move |t, x, u| {
            let (m, d) = of(t, u[1]);
            vec![(u[0] - d * x[0]) / m]
        }),
        shown: |x| x[0],
        states: 1,
        inputs: vec![stairs(7, n, (0.0, 4.0), 45), slow(8, n, 300.0, 15.0)],
        noise: 0.004,
        truth,
    }
}

/// A rotor of a share of the inertia, that drives the rest through a spring of this frequency (Hz); its angle, or that of the
/// rest, is what friction, a spring and the encoder work on.
fn arm(name: &'static str, share: f64, frequency: f64, is_sensor: bool) -> System {
    let (j, d, k, n) = (0.051, 0.048, 0.405, 1200);
    let w = std::f64::consts::TAU * frequency;
    let (rotor, load) = (share * j, (1.0 - share) * j);
    let spring = w * w * share * (1.0 - share) * j;
    let damper = 2.0 * 0.08 * spring / w;
    let rates = move |_: f64, x: &[f64], u: &[f64]| {
        let through = spring * (x[0] - x[2]) + damper * (x[1] - x[3]);
        let [own, other] =
            if is_sensor { [d * x[1] + k * x[0], 0.0] } else { [0.0, d * x[3] + k * x[2]] };
        vec![x[1], (u[0] - through - own) / rotor, x[3], (through - other) / load]
    };
    System {
        name,
        model: ARM.to_owned(),
        rates: Box::new(rates),
        shown: |x| x[2],
        states: 4,
        inputs: vec![stairs(9, n, (0.0, 0.3), 35)],
        noise: 0.001,
        truth: ("elastic-transmission", "joint"),
    }
}

pub(crate) fn dependences() -> Vec<System> {
    let of_drag = ("parameter-dependence", "d");
    vec![
        room("more air, less resistance", "parameter-dependence", |_, fan| {
            0.02 / (0.7 + 0.3 * fan)
        }),
        room("a little of that", "parameter-dependence", |_, fan| 0.02 / (0.9 + 0.1 * fan)),
        room("resistance with the root of the fan", "parameter-dependence", |_, fan| {
            0.02 / fan.max(0.1).sqrt()
        }),
        cart("oil gets thinner", of_drag, |_, oil| (2.02, 1.5 * (-0.03 * (oil - 300.0)).exp())),
        cart("oil gets a little thinner", of_drag, |_, oil| {
            (2.02, 1.5 * (-0.008 * (oil - 300.0)).exp())
        }),
        cart("drag is least at 300 K", of_drag, |_, oil| {
            (2.0, 1.3 + 0.006 * (oil - 300.0).powi(2))
        }),
    ]
}

pub(crate) fn events() -> Vec<System> {
    let [of_mass, of_drag] = ["m", "d"].map(|p| ("parameter-event", p));
    vec![
        room("a window is opened", "parameter-event", |t, _| if t < 7500.0 { 0.02 } else { 0.014 }),
        room("a window is open for a while", "parameter-event", |t, _| {
            if (4000.0..9000.0).contains(&t) { 0.015 } else { 0.02 }
        }),
        cart("something is loaded", of_mass, |t, _| (if t < 6.21 { 2.0 } else { 2.5 }, 1.5)),
        cart("something small is loaded", of_mass, |t, _| (if t < 9.3 { 2.0 } else { 2.15 }, 1.5)),
        cart("a brake rubs from then on", of_drag, |t, _| (2.0, if t < 4.0 { 1.5 } else { 2.1 })),
        cart("a bearing wears from then on", of_drag, |t, _| {
            (2.0, 1.5 + 0.12 * (t - 5.0_f64).max(0.0))
        }),
    ]
}

pub(crate) fn transmissions() -> Vec<System> {
    vec![
        arm("a belt of 6 Hz", 0.3, 6.0, false),
        arm("a gear of 12 Hz", 0.5, 12.0, false),
        arm("a soft coupling of 3 Hz", 0.2, 3.0, false),
        arm("a light rotor, 8 Hz", 0.1, 8.0, false),
        arm("an encoder behind a spring of 7 Hz", 0.85, 7.0, true),
        arm("an encoder behind a spring of 4 Hz", 0.7, 4.0, true),
    ]
}

/// A cart whose motor makes another force of a command: from the command and what it remembers, the force and the rate of that.
fn motor(
    name: &'static str,
    truth: &'static str,
    law: impl Fn(f64, f64) -> [f64; 2] + 'static,
) -> System {
    let cart = cart(name, (truth, "force"), |_, _| (2.02, 1.45));
    let rates = move |_: f64, x: &[f64], u: &[f64]| {
        let [force, rate] = law(u[0], x[1]);
        vec![(force - 1.45 * x[0]) / 2.02, rate]
    };
    System { rates: Box::new(rates), states: 2, ..cart }
}

/// An arm and what its encoder remembers: from its angle and speed and the memory, the rate of that; and what is shown.
fn encoder(
    name: &'static str,
    truth: &'static str,
    shown: Shown,
    memory: impl Fn(f64, f64, f64) -> f64 + 'static,
) -> System {
    let rates = move |_: f64, x: &[f64], u: &[f64]| {
        vec![x[1], (u[0] - 0.048 * x[1] - 0.405 * x[0]) / 0.051, memory(x[0], x[1], x[2])]
    };
    let arm = arm(name, 0.5, 1.0, false);
    System { rates: Box::new(rates), shown, states: 3, truth: (truth, "angle"), ..arm }
}

pub(crate) fn curves() -> Vec<System> {
    vec![
        motor("thrust with the square", "input-power", |u, _| [u * u.abs() / 3.0, 0.0]),
        motor("flow with the root", "input-power", |u, _| [1.8 * u.signum() * u.abs().sqrt(), 0.0]),
        motor("slower up than down", "input-asymmetric-lag", |u, a| {
            [a, (u - a) / if a < u { 0.3 } else { 0.1 }]
        }),
        motor("a valve that opens slowly", "input-rate-limit", |u, a| {
            [a, (300.0 * (u - a)).clamp(-20.0, 6.0)]
        }),
        encoder(
            "play behind",
            "sensor-backlash",
            |x| x[2],
            |q, w, p| {
                if (q - p) * w > 0.0 && 0.03 <= (q - p).abs() { w } else { 0.0 }
            },
        ),
        encoder(
            "hysteresis behind",
            "sensor-hysteresis",
            |x| x[0] - 0.04 * x[2],
            |_, w, z| (w - w.abs() * z) / 0.15,
        ),
    ]
}

#[test]
fn a_resistance_that_follows_a_fan_is_found() {
    let (is_found, said) = dependences()[0].is_found();
    assert!(is_found, "{said}");
}

#[test]
fn a_mass_that_is_loaded_is_found() {
    let (is_found, said) = events()[2].is_found();
    assert!(is_found, "{said}");
}

#[test]
fn a_belt_is_found() {
    let (is_found, said) = transmissions()[0].is_found();
    assert!(is_found, "{said}");
}

#[test]
fn a_thrust_with_the_square_of_the_command_is_found() {
    let (is_found, said) = curves()[0].is_found();
    assert!(is_found, "{said}");
}
