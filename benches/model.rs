//! How long do reduction, Hankel values, Lyapunov and Riccati equations and the H-infinity norm take?
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use criterion::{Criterion, criterion_group, criterion_main};
use faer::Mat;
use fdiag::model::{lyapunov, reduce, riccati};
use fdiag_benches::{MEASUREMENT, SAMPLES, WARM_UP, nominal_engine, random_plant, reduced};

/// Relative tolerance of the H-infinity norm.
const TOLERANCE: f64 = 1e-6;

fn reductions(c: &mut Criterion) {
    let engine = nominal_engine().unwrap().model;
    let mut group = c.benchmark_group("reduction of the engine, 17 to 5 states");
    group.bench_function("onto measured states", |b| b.iter(|| reduced(&engine).unwrap()));
    group.bench_function("balanced truncation", |b| {
        b.iter(|| reduce::balanced_truncation(&engine, 5).unwrap());
    });
    group.bench_function("balanced residualisation", |b| {
        b.iter(|| reduce::balanced_residualisation(&engine, 5).unwrap());
    });
    group.finish();
}

fn analyses(c: &mut Criterion) {
    for nx in [17, 100] {
        let plant = random_plant(nx, 1).unwrap();
        let (q, r): (Mat<f64>, Mat<f64>) = (Mat::identity(nx, nx), Mat::identity(3, 3));
        let mut group = c.benchmark_group(format!("random plant, {nx} states"));
        group.bench_function("Hankel values", |b| {
            b.iter(|| plant.hankel_singular_values().unwrap());
        });
        group.bench_function("discrete Riccati", |b| {
            b.iter(|| {
                riccati::discrete_filter(plant.a(), plant.c(), q.as_ref(), r.as_ref()).unwrap()
            });
        });
        group.bench_function("H-infinity norm", |b| {
            b.iter(|| plant.hinf_norm(TOLERANCE).unwrap());
        });
        group.finish();
    }
}

/// Truncation to 5 states, as its peer of another language does it.
fn truncations(c: &mut Criterion) {
    let mut group = c.benchmark_group("balanced truncation");
    group.sample_size(10);
    for nx in [17, 100, 500, 1000] {
        let plant = random_plant(nx, 1).unwrap();
        group.bench_function(format!("n = {nx}"), |b| {
            b.iter(|| reduce::balanced_truncation(&plant, 5).unwrap());
        });
    }
    group.finish();
}

/// Lyapunov equations of a random plant, and of the continuous one with the eigenvalues `λ − 1`.
fn covariances(c: &mut Criterion) {
    for nx in [17, 100, 500] {
        let plant = random_plant(nx, 1).unwrap();
        let (a, q) = (plant.a(), plant.b() * plant.b().transpose());
        let continuous = a - Mat::<f64>::identity(nx, nx);
        let mut group = c.benchmark_group(format!("Lyapunov equation, {nx} states"));
        group.sample_size(10);
        group.bench_function("discrete", |b| {
            b.iter(|| lyapunov::discrete(a, q.as_ref()).unwrap());
        });
        group.bench_function("continuous", |b| {
            b.iter(|| lyapunov::continuous(continuous.as_ref(), q.as_ref()).unwrap());
        });
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(SAMPLES)
        .warm_up_time(WARM_UP)
        .measurement_time(MEASUREMENT);
    targets = reductions, analyses, covariances, truncations
}
criterion_main!(benches);
