//! A small plant with a wrong model, and logs of it.
#![allow(clippy::unwrap_used, dead_code, unreachable_pub, reason = "each test uses its own part")]

pub mod physical;

use faer::mat;
use fdiag::{
    core::{Event, EventKind, Heap, Scalar, Step, stage::Phase},
    model::{
        Channel, Discrete, Inputs, Record, SampleTime, Simulation, StateSpace, signal::WhiteNoise,
    },
    spec::PipelineSpec,
};

/// Training on line, re-training when the input leaves the trained range.
pub const SPEC: &str = r#"
weighting = [[1.0, 0.5]]
settle_s = 0.0

[generator]
kind = "observer"
rate = 2.0

[bias]
orders = { kind = "fixed", na = 2, nb = 3 }
learning = { kind = "recursive", prior_variance = 1e6 }

[compensation]
operating_point = { policy = { kind = "retrain" } }

[detector]
kind = "maximum"
margin = 0.1

[rule]
raise = 3
out_of = 4
clear = 5
"#;

pub fn spec() -> PipelineSpec {
    SPEC.parse().unwrap()
}

pub fn ts() -> SampleTime {
    SampleTime::new(0.1).unwrap()
}

/// What the diagnosis believes.
pub fn nominal() -> StateSpace<Discrete> {
    let (a, b) = (mat![[0.90, 0.06], [-0.04, 0.83]], mat![[0.06], [0.11]]);
    let (c, d) = (mat![[1.0, 0.0], [0.3, 1.0]], mat![[0.0], [0.0]]);
    StateSpace::new(a, b, c, d, Discrete { ts: ts() }).unwrap()
}

/// What is really there.
pub fn plant() -> StateSpace<Discrete> {
    let (a, b) = (mat![[0.92, 0.05], [-0.03, 0.85]], mat![[0.05], [0.12]]);
    let (c, d) = (mat![[1.0, 0.0], [0.3, 1.0]], mat![[0.0], [0.0]]);
    StateSpace::new(a, b, c, d, Discrete { ts: ts() }).unwrap()
}

/// Levels that change every few seconds with two tones on top, within about ±0.5; `variant` moves
/// levels and phases.
pub fn input(samples: usize, variant: u32) -> Vec<f64> {
    let variant = f64::from(variant);
    (0..samples)
        .map(|k| {
            let t = k as f64 * ts().seconds();
            let level = 0.4 * ((t / 4.0).floor() * 2.1 + variant).sin();
            level + 0.05 * (1.3 * t + variant).sin() + 0.05 * (4.1 * t + 2.0 * variant).sin()
        })
        .collect()
}

/// A run of `plant` from rest with white sensor noise.
pub fn run(plant: &StateSpace<Discrete>, u: &[f64], noise: f64, seed: u64) -> Record {
    let nu = plant.nu();
    let inputs = Inputs::new(Channel::numbered("u", nu), u.to_vec(), u.len() / nu, ts()).unwrap();
    let sensors = (0..plant.ny() as u64)
        .map(|i| WhiteNoise::new(noise, seed.wrapping_mul(1000).wrapping_add(i)).into());
    let output_noise = if noise > 0.0 { sensors.collect() } else { Vec::new() };
    let simulation = Simulation { output_noise, ..Simulation::default() };
    let running = plant.freeze::<f64, Heap>().unwrap();
    simulation.run(&running, &inputs, Channel::numbered("y", plant.ny())).unwrap()
}

/// Healthy run for training.
pub fn training() -> Record {
    run(&plant(), &input(3000, 0), 1e-4, 1)
}

/// Healthy run for the threshold.
pub fn calibration() -> Record {
    run(&plant(), &input(1200, 3), 1e-4, 2)
}

/// A run whose input leaves the trained range at sample 600, so that the bias is learned again;
/// from sample 4600 on the second sensor is wrong by 0.05.
pub fn eventful() -> Record {
    let mut u = input(5000, 7);
    u[600..].iter_mut().for_each(|v| *v += 1.5);
    let mut record = run(&plant(), &u, 1e-4, 3);
    (4600..5000).for_each(|k| record.y_mut(k)[1] += 0.05);
    record
}

/// Everything that one sample produced, floats as bits so that equal means identical.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    pub k: u64,
    pub residual: Vec<u64>,
    pub compensated: Vec<u64>,
    pub phase: Phase,
    pub statistic: u64,
    pub threshold: u64,
    pub fault_since: Option<u64>,
    pub events: Vec<Event>,
}

impl Outcome {
    pub fn of<T: Scalar>(step: &Step<'_, T>) -> Self {
        let bits = |values: &[T]| values.iter().map(|v| v.to_report().to_bits()).collect();
        Self {
            k: step.k,
            residual: bits(step.residual),
            compensated: bits(step.compensated),
            phase: step.phase,
            statistic: step.verdict.statistic.to_report().to_bits(),
            threshold: step.verdict.threshold.to_report().to_bits(),
            fault_since: match step.decision {
                fdiag::core::stage::Decision::Fault(fault) => Some(fault.since),
                _ => None,
            },
            events: step.events.iter().map(|kind| Event { k: step.k, kind }).collect(),
        }
    }
}

pub fn count(outcomes: &[Outcome], kind: EventKind) -> usize {
    outcomes.iter().flat_map(|o| &o.events).filter(|event| event.kind == kind).count()
}
