//! A plant that falls without its controller: its free run is lost without the effect, and fits stay where they begin.

use fd_gap::diagnose::{Case, Settings, Verdict, diagnose};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::model::Model;

use super::road::{record, suspects};

const MODEL: &str = r#"
version = 1
kind = "equations"
name = "balancing cart"
sample_time = 0.01
[parameters]
M = { unit = "kg", value = 0.8, tolerance = 0.04 }
m = { unit = "kg", value = 0.25, tolerance = 0.03 }
l = { unit = "m", value = 0.45, tolerance = 0.02 }
d = { unit = "N s/m", value = 0.6, tolerance = 0.2 }
[inputs]
force = { unit = "N" }
[states]
x = { unit = "m", initial = 0.0, tolerance = 0.01, derivative = "v" }
v = { unit = "m/s", initial = 0.0, tolerance = 0.02, derivative = "(F - cos(phi)*G)/mass" }
phi = { unit = "rad", initial = 0.0, tolerance = 0.01, derivative = "omega" }
omega = { unit = "rad/s", initial = 0.0, tolerance = 0.03, derivative = "((M + m)*G/m - cos(phi)*F)/(l*mass)" }
[outputs]
cart = { unit = "m", value = "x", noise = 0.003 }
tilt = { unit = "rad", value = "phi", noise = 0.0008 }
[definitions]
F = "force - d*v + m*l*omega^2*sin(phi)"
G = "m*9.81*sin(phi)"
mass = "M + m*sin(phi)^2"
[sites]
rail = { unit = "N", enters = { v = "1/mass", omega = "-cos(phi)/(l*mass)" }, position = "x", velocity = "v" }
pivot = { unit = "N m", enters = { v = "-cos(phi)/(l*mass)", omega = "(M + m)/(m*l^2*mass)" }, position = "phi", velocity = "omega" }
[controller]
sample_time = 0.01
[controller.references]
wanted = { unit = "m" }
[controller.states]
cart_slow = { unit = "m", initial = 0.0, update = "cart_slow + (cart - cart_slow)/3" }
tilt_slow = { unit = "rad", initial = 0.0, update = "tilt_slow + (tilt - tilt_slow)/3" }
[controller.signals]
force = "3.5*(cart - wanted) + 4.5*(cart - cart_slow)/0.03 + 34.5*tilt + 6.8*(tilt - tilt_slow)/0.03"
"#;

/// Samples of a log.
const SAMPLES: usize = 2000;

/// The cart, whose motor does next to nothing with a small command.
fn run(model: &Model, run: u32) -> Record {
    let (h, dead, soft) = (0.01, 1.2, 0.07);
    // What is beyond the zone, with a round corner; far beyond, one plus the exponential would overflow.
    let beyond = |z: f64| if 30.0 * soft < z { z } else { soft * (z / soft).exp().ln_1p() };
    let [mut x, mut v, mut phi, mut omega] = [0.003, -0.004, 0.002, -0.004];
    let noise = [(0.003, 2 * run), (0.0008, 2 * run + 1)]
        .map(|(size, seed)| WhiteNoise::new(size, u64::from(seed)).values(SAMPLES).unwrap());
    let mut slow = [0.0; 2];
    let levels = [0.0, 0.186, 0.324, 0.03, -0.03, 0.288, 0.386, 0.361, 0.125, 0.128, 0.199, -0.49];
    let rows = (0..SAMPLES).map(|k| {
        let wanted = levels[(k / 190 + run as usize) % levels.len()];
        let seen = [x + noise[0][k], phi + noise[1][k]];
        let rates = [(seen[0] - slow[0]) / 0.03, (seen[1] - slow[1]) / 0.03];
        for (slow, seen) in slow.iter_mut().zip(seen) {
            *slow += (seen - *slow) / 3.0;
        }
        let command = 3.5 * (seen[0] - wanted) + 4.5 * rates[0] + 34.5 * seen[1] + 6.8 * rates[1];
        let acts = beyond(command - dead) - beyond(-command - dead);
        // A hundred semi-implicit Euler steps: 1e-4 s beside an unstable pole of 6/s.
        for _ in 0..100 {
            let step = h / 100.0;
            let (mass, force) = (
                0.8 + 0.25 * f64::sin(phi).powi(2),
                acts - 0.65 * v + 0.25 * 0.448 * omega * omega * f64::sin(phi),
            );
            let gravity = 0.25 * 9.81 * f64::sin(phi);
            v += step * (force - f64::cos(phi) * gravity) / mass;
            omega += step * (1.05 * gravity / 0.25 - f64::cos(phi) * force) / (0.448 * mass);
            (x, phi) = (x + step * v, phi + step * omega);
        }
        ([wanted], seen)
    });
    record(model, rows)
}

/// A power law is nearest to the round corner. Among two labels its fit stayed in a wrong valley, ten times further from the log
/// than among six, of which one led it out by chance.
#[test]
fn a_law_is_found_whatever_else_is_tried() {
    let model: Model = MODEL.parse().unwrap();
    let (logs, held_out) = ([run(&model, 1)], [run(&model, 2)]);
    let found = |few: &[&str]| {
        let suspects = suspects(&model, &logs[0], few);
        let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
        diagnose(&case, &Settings::default(), &()).unwrap()
    };
    let two = found(&["input-power", "input-dead-zone"]);
    let others = ["input-gain", "resonant-mode", "coulomb-friction", "sensor-delay"];
    let six = found(&[&["input-power", "input-dead-zone"][..], &others].concat());
    for found in [&two, &six] {
        let first = &found.causes[0];
        assert_eq!((found.verdict, first.label), (Verdict::Cause, "input-power"));
        let refit = found.refit.gap.iter().fold(0.0_f64, |most, gap| most.max(*gap));
        assert!(first.gap < 0.2 * refit, "{} of {refit}", first.gap);
    }
    // Two of its laws are as good; of 400 replicas a few go to the other one.
    let [two, six] = [two, six].map(|found| found.causes[0].probability);
    assert!((two - six).abs() < 0.02, "{two} {six}");
}
