//! How long does a diagnosis take, on one core, and what is it made of?
//!
//! * Simulations per second of each plant, one run at a time and up to sixteen side by side.
//! * A diagnosis of 1000 samples and at most 60 candidates of each plant; "elements" are
//!   candidates, so that its inverse is the cost of one.
//! * How that grows with the number of samples; near-linear when samples per second stay the same.
//! * The same with one core and with two.
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::{hint::black_box, path::Path, time::Duration};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fd_effect::{Candidate, Kind, Side, library, offers};
use fd_gap::diagnose::{Case, Settings, diagnose};
use fd_sim::{
    model::Model,
    scales::ReplayScales,
    simulate::{EquationSimulator, Run, Simulator},
};
use fdiag::model::{Record, signal::WhiteNoise};
use rayon::ThreadPoolBuilder;

/// Plants, with the amplitude of their input.
const PLANTS: [(&str, f64); 8] = [
    ("mass_spring_damper", 10.0),
    ("dc_drive", 20.0),
    ("dc_drive_closed_loop", 5.0),
    ("pendulum", 1.0),
    ("cart_pole", 5.0),
    ("two_mass_drive", 1.0),
    ("tanks", 5.0),
    ("two_input", 2.0),
];
/// Candidates of a diagnosis.
const CANDIDATES: usize = 60;
/// Relative error of the parameters of the real plant.
const PARAMETER_ERROR: f64 = 0.01;
/// Integration steps of the real plant per step of the simulator.
const FINER: usize = 4;
/// Samples of a log.
const SAMPLES: usize = 1000;

fn plant(name: &str) -> Model {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/models");
    Model::load(&root.join(format!("{name}.toml"))).unwrap()
}

/// Steps held for 25 samples, each input with steps of its own.
fn excitation(inputs: usize, amplitude: f64, samples: usize) -> Vec<f64> {
    let level = |k: usize, i: usize| ((k / 25 * 7919 + i * 104_729) % 211) as f64 / 105.0 - 1.0;
    (0..samples).flat_map(|k| (0..inputs).map(move |i| amplitude * level(k, i))).collect()
}

/// Candidates, spread over the library, and a log of a plant that has one of the effects in its
/// dynamics, parameters that are off, and noise.
fn case(model: &Model, amplitude: f64, samples: usize, most: usize) -> (Vec<Candidate>, Record) {
    let ts = model.sample_time().unwrap();
    let u = excitation(model.external_inputs().len(), amplitude, samples);
    let scales = ReplayScales::of(model, ts, &u, samples).unwrap();
    let all: Vec<Candidate> = offers(&library(), model, &scales)
        .into_iter()
        .filter_map(Result::ok)
        .filter(|candidate| candidate.kind == Kind::Simulation)
        .collect();
    let truth = all.iter().find(|candidate| candidate.side == Side::Dynamics).unwrap();
    let mut theta = truth.model.nominal();
    let nominal = theta.len() - truth.parameters.len();
    let (known, effect) = theta.split_at_mut(nominal);
    for (i, value) in known.iter_mut().enumerate() {
        *value *= 1.0 + if i % 2 == 0 { PARAMETER_ERROR } else { -PARAMETER_ERROR };
    }
    effect.copy_from_slice(truth.starts.last().unwrap());
    let mut real = EquationSimulator::<f64>::at(&truth.model, ts).unwrap().refined(FINER);
    let ny = model.outputs.len();
    let mut y = vec![0.0; samples * ny];
    Simulator::simulate(&mut real, &theta, &truth.model.initial(), &u, &mut y);
    for (c, output) in model.outputs.iter().enumerate() {
        let noise = WhiteNoise::new(output.noise.unwrap(), c as u64).values(samples).unwrap();
        y.iter_mut().skip(c).step_by(ny).zip(noise).for_each(|(y, e)| *y += e);
    }
    let log = Record::new(model.external_inputs(), model.output_channels(), u, y, ts).unwrap();
    let count = most.min(all.len());
    let spread = (0..count).map(|i| all[i * all.len() / count].clone()).collect();
    (spread, log)
}

fn simulations(c: &mut Criterion) {
    let mut group = c.benchmark_group("simulations of 1000 samples");
    group.sample_size(10).warm_up_time(Duration::from_millis(100));
    group.measurement_time(Duration::from_millis(500));
    for (name, amplitude) in PLANTS {
        let model = plant(name);
        let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
        let u = excitation(model.external_inputs().len(), amplitude, SAMPLES);
        let (theta, x0) = (model.nominal(), model.initial());
        for count in [1, 4, 8, 16] {
            let mut y = vec![vec![0.0; SAMPLES * model.outputs.len()]; count];
            group.throughput(Throughput::Elements(count as u64));
            group.bench_function(BenchmarkId::new(name, format!("{count} side by side")), |b| {
                b.iter(|| {
                    let mut runs: Vec<Run<'_>> =
                        y.iter_mut().map(|y| Run::new(black_box(&theta), &x0, y)).collect();
                    simulator.simulate_many(0, &u, &mut runs);
                });
            });
        }
    }
    group.finish();
}

fn diagnoses(c: &mut Criterion) {
    let one_thread = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut group = c.benchmark_group("diagnosis of 1000 samples");
    group.sample_size(10).warm_up_time(Duration::from_millis(100));
    group.measurement_time(Duration::from_secs(4));
    for (name, amplitude) in PLANTS {
        let model = plant(name);
        let (candidates, log) = case(&model, amplitude, SAMPLES, CANDIDATES);
        let logs = [log];
        let case = Case { nominal: &model, suspects: &candidates, logs: &logs, held_out: &[] };
        group.throughput(Throughput::Elements(candidates.len() as u64));
        group.bench_function(format!("{name}, {} candidates", candidates.len()), |b| {
            b.iter(|| {
                one_thread
                    .install(|| diagnose(black_box(&case), &Settings::default(), &()).unwrap())
            });
        });
    }
    group.finish();
}

fn scaling(c: &mut Criterion) {
    let one_thread = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut group = c.benchmark_group("diagnosis of mass_spring_damper, 12 candidates");
    group.sample_size(10).warm_up_time(Duration::from_millis(100));
    group.measurement_time(Duration::from_secs(2));
    let model = plant("mass_spring_damper");
    for samples in [250, 500, 1000, 2000, 4000] {
        let (candidates, log) = case(&model, 10.0, samples, 12);
        let logs = [log];
        let case = Case { nominal: &model, suspects: &candidates, logs: &logs, held_out: &[] };
        group.throughput(Throughput::Elements(samples as u64));
        group.bench_function(BenchmarkId::from_parameter(samples), |b| {
            b.iter(|| {
                one_thread
                    .install(|| diagnose(black_box(&case), &Settings::default(), &()).unwrap())
            });
        });
    }
    group.finish();
}

fn cores(c: &mut Criterion) {
    let mut group = c.benchmark_group("diagnosis of dc_drive, cores");
    group.sample_size(10).warm_up_time(Duration::from_millis(100));
    group.measurement_time(Duration::from_secs(4));
    let model = plant("dc_drive");
    let (candidates, log) = case(&model, 20.0, SAMPLES, CANDIDATES);
    let logs = [log];
    let case = Case { nominal: &model, suspects: &candidates, logs: &logs, held_out: &[] };
    group.throughput(Throughput::Elements(candidates.len() as u64));
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        group.bench_function(BenchmarkId::from_parameter(threads), |b| {
            b.iter(|| {
                pool.install(|| diagnose(black_box(&case), &Settings::default(), &()).unwrap())
            });
        });
    }
    group.finish();
}

criterion_group!(benches, simulations, diagnoses, scaling, cores);
criterion_main!(benches);
