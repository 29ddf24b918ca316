//! A law that is planted with any strength of its box is found by its own fit.

use fd_effect::{Candidate, Suspects};
use fd_gap::diagnose::{Case, Settings, diagnose};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};

use super::road::{record, suspects};

const TROLLEY: &str = r#"
version = 1
kind = "equations"
name = "trolley"
sample_time = 0.04
parameters = { T = { unit = "s", value = 0.2, tolerance = 0.2 } }
inputs = { u = { unit = "m/s" } }
states.x = { unit = "m", initial = 0.0, derivative = "v" }
states.v = { unit = "m/s", initial = 0.0, derivative = "(u - v)/T" }
outputs = { place = { unit = "m", value = "x", noise = 0.02 } }
"#;
const MOTOR: &str = r#"
version = 1
kind = "equations"
name = "motor"
sample_time = 0.01
parameters.J = { unit = "kg*m^2", value = 0.002, tolerance = 0.1 }
parameters.K = { unit = "N*m/V", value = 0.05, tolerance = 0.05 }
inputs = { u = { unit = "V" } }
states = { w = { unit = "rad/s", initial = 0.0, derivative = "(K*u - 0.01*w)/J" } }
outputs = { speed = { unit = "rad/s", value = "w", noise = 0.08 } }
"#;

const SAMPLES: usize = 800;
/// How far the plant is from its model, in tolerances.
const APART: f64 = 0.4;
/// What a law must change to be worth looking for, in noise.
const SEEN: f64 = 3.0;
/// Of 800 samples, the root mean square of noise is within a tenth of its size (four of its deviations); a step that is just
/// fine enough takes another twentieth.
const AT_THE_NOISE: f64 = 1.15;
/// One in so many may be lost: today two in 217, an asymmetric saturation and an asymmetric rate limit of a trolley.
const ONE_IN: usize = 100;

fn steps(k: usize) -> f64 {
    [1.5, -0.4, 1.0, -1.2, 0.6, -1.5, 0.2, 1.2][(k / 45) % 8]
}

fn waves(k: usize) -> f64 {
    let t = k as f64;
    0.9 * (0.031 * t).sin() + 0.5 * (0.13 * t).sin() + 0.3 * (0.41 * t).cos() - 0.3
}

/// The candidate's model, somewhat apart from the nominal one, with a strength and else where its fits start.
fn outputs(candidate: &Candidate, strength: Option<f64>, u: &[f64]) -> Vec<f64> {
    let model = &candidate.model;
    let simulator = EquationSimulator::<f64>::at(model, model.sample_time().unwrap()).unwrap();
    let mut simulator = simulator.refined(16);
    let first = simulator.parameters().len() - candidate.parameters.len();
    let apart = model.parameters.iter().map(|p| p.value * (1.0 + APART * p.tolerance));
    let mut theta: Vec<f64> = apart.collect();
    theta.truncate(first);
    theta.extend(
        candidate
            .parameters
            .iter()
            .zip(&candidate.starts[0])
            .map(|(p, start)| if p.is_strength { strength.unwrap_or(p.neutral) } else { *start }),
    );
    let x0 = model.initial();
    let mut y = vec![0.0; u.len()];
    simulator.simulate(&theta, &x0, u, &mut y);
    y
}

fn log_of(model: &Model, u: &[f64], y: &[f64], seed: u64) -> Record {
    let noise = WhiteNoise::new(model.outputs[0].noise.unwrap(), seed).values(u.len()).unwrap();
    record(model, u.iter().zip(y.iter().zip(noise)).map(|(u, (y, noise))| ([*u], [y + noise])))
}

/// Limits, plays, zones and delays of every size that shows: a sum of squares may have valleys between the starts of a fit.
#[test]
fn every_strength_of_a_law_is_found_by_its_fit() {
    let wanted = [
        "input-saturation",
        "input-backlash",
        "input-dead-zone",
        "input-rate-limit",
        "input-lag",
        "input-delay",
    ];
    let (mut planted, mut lost) = (0_usize, Vec::new());
    for (text, size) in [(TROLLEY, 1.0), (MOTOR, 4.0)] {
        let model: Model = text.parse().unwrap();
        for command in [steps, waves] {
            let u: Vec<f64> = (0..SAMPLES).map(|k| size * command(k)).collect();
            let still = log_of(&model, &u, &vec![0.0; SAMPLES], 1);
            let suspects = suspects(&model, &still, &wanted);
            for candidate in suspects.alone().into_iter().flatten() {
                let strength = candidate.parameters.iter().find(|p| p.is_strength).unwrap();
                let plain = outputs(&candidate, None, &u);
                for part in [0.003, 0.02, 0.1, 0.4, 0.8] {
                    let value = part * strength.high;
                    let y = outputs(&candidate, Some(value), &u);
                    let squares: f64 = y.iter().zip(&plain).map(|(a, b)| (a - b).powi(2)).sum();
                    let change = (squares / SAMPLES as f64).sqrt();
                    let [_, motion] = fd_numeric::mean_and_deviation(y.iter().copied());
                    let noise = model.outputs[0].noise.unwrap();
                    if change < SEEN * noise || motion < SEEN * noise {
                        continue;
                    }
                    planted += 1;
                    let logs = [log_of(&model, &u, &y, 7 + planted as u64)];
                    let alone = vec![candidate.clone()];
                    let case =
                        Case { nominal: &model, suspects: &alone, logs: &logs, held_out: &[] };
                    let found = diagnose(&case, &Settings::default(), &()).unwrap();
                    let first = &found.causes[0];
                    if AT_THE_NOISE < first.gap {
                        let Candidate { label, law, .. } = &candidate;
                        let at = first.parameters[0].value;
                        lost.push(format!("{label} {law} {value} -> {at}, {:.1}", first.gap));
                    }
                }
            }
        }
    }
    assert!(100 < planted && ONE_IN * lost.len() <= planted, "{planted} planted, lost: {lost:#?}");
}
