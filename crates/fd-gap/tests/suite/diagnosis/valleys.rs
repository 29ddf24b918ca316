//! A law that is planted with any strength or shape of its box is found by its own fit.

use fd_effect::{Candidate, EffectParameter, Suspects, with_default_sites};
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
/// One in so many may be lost: today two in 210, an asymmetric saturation and an asymmetric rate limit of a trolley.
const ONE_IN: usize = 100;
/// The same of laws of any shape: today three in 245, before end stops had starts away from the middle nine in 243.
const ONE_IN_SHAPES: usize = 60;

fn steps(k: usize) -> f64 {
    [1.5, -0.4, 1.0, -1.2, 0.6, -1.5, 0.2, 1.2][(k / 45) % 8]
}

fn waves(k: usize) -> f64 {
    let t = k as f64;
    0.9 * (0.031 * t).sin() + 0.5 * (0.13 * t).sin() + 0.3 * (0.41 * t).cos() - 0.3
}

/// The first start of a candidate with this strength; `None` for none.
fn with_strength(candidate: &Candidate, strength: Option<f64>) -> Vec<f64> {
    let each = candidate.parameters.iter().zip(&candidate.starts[0]);
    each.map(|(p, start)| if p.is_strength { strength.unwrap_or(p.neutral) } else { *start })
        .collect()
}

/// A point of the box of a candidate, of a sequence that fills it (Halton 1960): strengths from half the least to twice the most
/// that a start has, shapes anywhere.
fn anywhere(candidate: &Candidate, number: usize) -> Vec<f64> {
    let each = candidate.parameters.iter().enumerate();
    each.map(|(i, p)| {
        let sizes = || candidate.starts.iter().map(|start| start[i].abs());
        let part = radical_inverse(number, [2, 3, 5, 7][i]);
        let EffectParameter { mut low, mut high, .. } = *p;
        if p.is_strength {
            low = 0.5 * sizes().fold(f64::INFINITY, f64::min);
            high = (2.0 * sizes().fold(0.0, f64::max)).min(high);
        }
        // What may be twenty times as large is as likely of any order of magnitude.
        let is_wide = 0.0 < low && 20.0 * low < high;
        if is_wide { low * (high / low).powf(part) } else { low + part * (high - low) }
    })
    .collect()
}

/// The digits of a number behind the point, the last one first.
fn radical_inverse(number: usize, base: usize) -> f64 {
    if number == 0 {
        return 0.0;
    }
    ((number % base) as f64 + radical_inverse(number / base, base)) / base as f64
}

/// What the candidate's model shows, somewhat apart from the nominal one, with these values of its parameters.
fn outputs(candidate: &Candidate, values: &[f64], u: &[f64]) -> Vec<f64> {
    let model = &candidate.model;
    let simulator = EquationSimulator::<f64>::at(model, model.sample_time().unwrap()).unwrap();
    let mut simulator = simulator.refined(16);
    let first = simulator.parameters().len() - candidate.parameters.len();
    let apart = model.parameters.iter().map(|p| p.value * (1.0 + APART * p.tolerance));
    let mut theta: Vec<f64> = apart.collect();
    theta.truncate(first);
    theta.extend(values);
    let x0 = model.initial();
    let mut y = vec![0.0; u.len()];
    simulator.simulate(&theta, &x0, u, &mut y);
    y
}

fn log_of(model: &Model, u: &[f64], y: &[f64], seed: u64) -> Record {
    let noise = WhiteNoise::new(model.outputs[0].noise.unwrap(), seed).values(u.len()).unwrap();
    record(model, u.iter().zip(y.iter().zip(noise)).map(|(u, (y, noise))| ([*u], [y + noise])))
}

/// Plants what `values` says of each of the wanted candidates on both plants; says how many showed, and what was lost.
fn planted(
    wanted: &[&str],
    with_sites: impl Fn(&Model) -> Model,
    values: impl Fn(&Candidate) -> Vec<Vec<f64>>,
) -> (usize, Vec<String>) {
    let (mut planted, mut lost) = (0_usize, Vec::new());
    for (text, size) in [(TROLLEY, 1.0), (MOTOR, 4.0)] {
        let model = with_sites(&text.parse().unwrap());
        let noise = model.outputs[0].noise.unwrap();
        for command in [steps, waves] {
            let u: Vec<f64> = (0..SAMPLES).map(|k| size * command(k)).collect();
            let still = log_of(&model, &u, &vec![0.0; SAMPLES], 1);
            let suspects = suspects(&model, &still, wanted);
            for candidate in suspects.alone().into_iter().flatten() {
                let plain = outputs(&candidate, &with_strength(&candidate, None), &u);
                for values in values(&candidate) {
                    let y = outputs(&candidate, &values, &u);
                    let squares: f64 = y.iter().zip(&plain).map(|(a, b)| (a - b).powi(2)).sum();
                    let change = (squares / SAMPLES as f64).sqrt();
                    let [_, motion] = fd_numeric::mean_and_deviation(y.iter().copied());
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
                        lost.push(format!("{label} {law} {values:?} -> {at}, {:.1}", first.gap));
                    }
                }
            }
        }
    }
    (planted, lost)
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
    let (planted, lost) = planted(&wanted, Model::clone, |candidate| {
        let strength = candidate.parameters.iter().find(|p| p.is_strength).unwrap();
        let sizes = [0.003, 0.02, 0.1, 0.4, 0.8].map(|part| part * strength.high);
        sizes.map(|size| with_strength(candidate, Some(size))).into()
    });
    assert!(100 < planted && ONE_IN * lost.len() <= planted, "{planted} planted, lost: {lost:#?}");
}

/// Laws whose strengths and shapes are anywhere.
#[test]
fn every_shape_of_a_law_is_found_by_its_fit() {
    let wanted = ["elastic-transmission", "end-stop", "coulomb-friction", "hysteresis"];
    let (planted, lost) = planted(&wanted, with_default_sites, |candidate| {
        (34..40).map(|n| anywhere(candidate, n)).collect()
    });
    assert!(
        100 < planted && ONE_IN_SHAPES * lost.len() <= planted,
        "{planted} planted, lost: {lost:#?}"
    );
}
