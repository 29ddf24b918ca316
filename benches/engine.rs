//! How long do the engine's equations, a run of it, and one trial of the benchmark take?
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use fd_lab::engine::{Benchmark, EngineConfig, TrainingRun};
use fdiag::{
    core::Heap,
    jetengine::engine17::{Engine17, Parameters, PerUnit, PowerSetting, Sampled},
    model::{SampleTime, Simulation},
};
use fdiag_benches::{MEASUREMENT, SAMPLES, WARM_UP, nominal_engine};

fn equations(c: &mut Criterion) {
    let engine = Engine17::<f64>::new(&Parameters::default()).unwrap();
    let fuel = PowerSetting::Reference.fuel();
    let trim = engine.trim(fuel).unwrap();
    let idle = PowerSetting::Idle.fuel();
    let mut group = c.benchmark_group("engine17");
    group.bench_function("right-hand side", |b| b.iter(|| engine.rhs(black_box(&trim.x), fuel)));
    group.bench_function("trim at idle from the reference point", |b| {
        b.iter(|| engine.trim(black_box(idle)).unwrap());
    });
    group.bench_function("linearisation", |b| {
        b.iter(|| engine.linearise(black_box(&trim)).unwrap());
    });
    group.finish();
}

fn runs(c: &mut Criterion) {
    let ts = SampleTime::new(0.05).unwrap();
    let nominal = nominal_engine().unwrap();
    let inputs = TrainingRun::default().inputs(&nominal.inputs, ts).unwrap();
    let linear = nominal.model.sample_zoh(ts).unwrap().freeze::<f64, Heap>().unwrap();
    let engine = Engine17::<f64>::new(&Parameters::default()).unwrap();
    let fuel = PowerSetting::Reference.fuel();
    let at = engine.trim(fuel).unwrap().x;
    let nonlinear = PerUnit::new(Sampled::new(engine, ts), at, fuel).unwrap();
    let simulation = Simulation::default();
    let mut group = c.benchmark_group(format!("run of {} samples", inputs.len()));
    group.bench_function("linear", |b| {
        b.iter(|| simulation.run(&linear, &inputs, nominal.outputs.clone()).unwrap());
    });
    group.bench_function("nonlinear", |b| {
        b.iter(|| simulation.run(&nonlinear, &inputs, nominal.outputs.clone()).unwrap());
    });
    group.finish();
}

fn trials(c: &mut Criterion) {
    let benchmark = Benchmark::new(EngineConfig::default()).unwrap();
    c.bench_function("trial/default", |b| b.iter(|| benchmark.trial(black_box(1)).unwrap()));
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(SAMPLES)
        .warm_up_time(WARM_UP)
        .measurement_time(MEASUREMENT);
    targets = equations, runs, trials
}
criterion_main!(benches);
