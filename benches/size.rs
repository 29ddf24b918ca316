//! What does a larger model cost, per state and per candidate?
//!
//! Independent lags with one input, each of them measured, so that 100 of them are 100 states and 100 outputs.
//!
//! * Simulations of 1000 samples, sixteen side by side; "elements" are states times runs, so that its inverse is the cost
//!   of a state.
//! * Candidates of the whole library; "elements" are candidates.
//! * A diagnosis among 60 candidates spread over the library; "elements" are candidates. Each state is one more output to
//!   compare and one more uncertain parameter, so that the cost of a candidate grows with the square of their number.
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::{fmt::Write, hint::black_box, time::Duration};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fd_effect::{Candidate, Kind, library, offers};
use fd_gap::diagnose::{Case, Settings, diagnose};
use fd_sim::{
    model::Model,
    scales::ReplayScales,
    simulate::{EquationSimulator, Run, Simulator},
};
use fdiag::model::{Record, signal::WhiteNoise};

/// Samples of a log.
const SAMPLES: usize = 1000;
/// Runs side by side.
const LANES: usize = 16;
/// Candidates of a diagnosis.
const CANDIDATES: usize = 60;
/// Standard deviation of the noise, V.
const NOISE: f64 = 0.01;
/// Dead zone of the real input, V.
const DEAD_ZONE: f64 = 0.3;

/// Independent lags from 50 ms on, each 2 % slower than the one before.
fn lags(states: usize) -> Model {
    let mut text = String::from(
        "version = 1\nkind = \"equations\"\nname = \"lags\"\nsample_time = 0.01\n[parameters]\n",
    );
    for i in 0..states {
        let time = 0.05 * 1.02_f64.powi(i32::try_from(i).unwrap());
        writeln!(text, "T{i} = {{ unit = \"s\", value = {time}, tolerance = 0.03 }}").unwrap();
    }
    text += "[inputs]\nu = { unit = \"V\" }\n[states]\n";
    for i in 0..states {
        let law = format!("(u - x{i})/T{i}");
        writeln!(text, "x{i} = {{ unit = \"V\", initial = 0.0, derivative = \"{law}\" }}").unwrap();
    }
    text += "[outputs]\n";
    for i in 0..states {
        writeln!(text, "y{i} = {{ unit = \"V\", value = \"x{i}\", noise = {NOISE} }}").unwrap();
    }
    text.parse().unwrap()
}

/// Steps held for 25 samples.
fn excitation() -> Vec<f64> {
    (0..SAMPLES).map(|k| ((k / 25 * 7919) % 211) as f64 / 52.0 - 2.0).collect()
}

fn candidates(model: &Model) -> Vec<Candidate> {
    let scales = ReplayScales::of(model, model.sample_time().unwrap(), &excitation(), SAMPLES);
    offers(&library(), model, &scales.unwrap()).into_iter().filter_map(Result::ok).collect()
}

/// A log of lags behind a dead zone.
fn log(model: &Model) -> Record {
    let (u, ny) = (excitation(), model.outputs.len());
    let arrives: Vec<f64> = u.iter().map(|u| u - u.clamp(-DEAD_ZONE, DEAD_ZONE)).collect();
    let mut y = vec![0.0; SAMPLES * ny];
    let mut real = EquationSimulator::<f64>::new(model).unwrap();
    Simulator::simulate(&mut real, &model.nominal(), &model.initial(), &arrives, &mut y);
    for c in 0..ny {
        let noise = WhiteNoise::new(NOISE, c as u64).values(SAMPLES).unwrap();
        y.iter_mut().skip(c).step_by(ny).zip(noise).for_each(|(y, e)| *y += e);
    }
    let ts = model.sample_time().unwrap();
    Record::new(model.external_inputs(), model.output_channels(), u, y, ts).unwrap()
}

fn per_state(c: &mut Criterion) {
    let mut group = c.benchmark_group("simulation, per state");
    group.sample_size(10).warm_up_time(Duration::from_millis(100));
    group.measurement_time(Duration::from_millis(500));
    for states in [10, 30, 60, 100] {
        let model = lags(states);
        let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
        let (u, theta, x0) = (excitation(), model.nominal(), model.initial());
        let mut y = vec![vec![0.0; SAMPLES * states]; LANES];
        group.throughput(Throughput::Elements((states * LANES) as u64));
        group.bench_function(BenchmarkId::from_parameter(states), |b| {
            b.iter(|| {
                let mut runs: Vec<Run<'_>> =
                    y.iter_mut().map(|y| Run::new(black_box(&theta), &x0, y)).collect();
                simulator.simulate_many(0, &u, &mut runs);
            });
        });
    }
    group.finish();
}

fn per_candidate(c: &mut Criterion) {
    let mut group = c.benchmark_group("candidates of the library");
    group.sample_size(10).warm_up_time(Duration::from_millis(100));
    group.measurement_time(Duration::from_millis(500));
    for states in [10, 30] {
        let model = lags(states);
        let scales = ReplayScales::of(&model, model.sample_time().unwrap(), &excitation(), SAMPLES);
        let (scales, effects) = (scales.unwrap(), library());
        group.throughput(Throughput::Elements(candidates(&model).len() as u64));
        group.bench_function(BenchmarkId::from_parameter(states), |b| {
            b.iter(|| offers(&effects, black_box(&model), &scales));
        });
    }
    group.finish();
    let mut group = c.benchmark_group("diagnosis among 60 candidates");
    group.sample_size(10).warm_up_time(Duration::from_millis(100));
    for states in [3, 10, 30] {
        let model = lags(states);
        let all = candidates(&model);
        let all: Vec<Candidate> = all.into_iter().filter(|c| c.kind == Kind::Simulation).collect();
        let spread = (0..CANDIDATES).map(|i| all[i * all.len() / CANDIDATES].clone());
        let suspects: Vec<Candidate> = spread.collect();
        let logs = [log(&model)];
        let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &[] };
        let settings = Settings::default();
        group.throughput(Throughput::Elements(CANDIDATES as u64));
        group.bench_function(BenchmarkId::from_parameter(states), |b| {
            b.iter(|| diagnose(black_box(&case), &settings, &()).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, per_state, per_candidate);
criterion_main!(benches);
