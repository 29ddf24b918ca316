//! What does one update of recursive least squares cost: alone, side by side, in a fleet?
//!
//! * Alone, by number of parameters: `UD` is the default factorisation, `P` the conventional
//!   covariance form, `QR` the reference; on the stack (`fixed`) or on the heap. Peers of other
//!   projects take the same samples.
//! * Side by side (`batch`): 64 estimators and 64 samples of each, which fit into a cache.
//! * A fleet of a million estimators, which does not.
//! * What the arithmetic of the machine would allow: fused multiply-adds per second.
//!
//! All forget by λ = 0.999, except `dsmc`, which has a random walk of variance zero instead.
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::{hint::black_box, time::Duration};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dsmc::system_identification::kalman_filter::whitebox::KalmanFilter;
use fdiag::{
    core::{Heap, Scalar},
    ident::{
        batch::{BatchRls, LaneScalar, Machine, SampleBlock},
        rls::{ConventionalRls, Forgetting, QrRls, RlsDesign, RlsKernel, Static, UdRls},
    },
};
use fdiag_benches::{MEASUREMENT, SAMPLES, WARM_UP, fused_multiply_adds};
use oxictl::{adaptive::rls::Rls as OxictlRls, core::adaptive_filters::rls::RlsFilter};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::ThreadPoolBuilder;

/// Samples that a single estimator goes through again and again.
const UPDATES: usize = 256;
const LAMBDA: f64 = 0.999;
/// Both forms are benched in both scalars, so the prior is one that f32 can hold in either.
const PRIOR: f64 = 1e2;
/// Estimators side by side, and samples of each.
const BATCH: (usize, usize) = (64, 64);
const FLEET: (usize, usize) = (1_000_000, 16);

fn design() -> RlsDesign {
    RlsDesign {
        prior_variance: PRIOR,
        ..RlsDesign::forgetting(Forgetting::Exponential { lambda: LAMBDA })
    }
}

/// Uniform regressors and targets.
fn samples<T: Scalar, const N: usize>() -> Vec<([T; N], T)> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(N as u64);
    let mut uniform = || T::from_design(rng.random_range(-1.0..1.0));
    (0..UPDATES).map(|_| (std::array::from_fn(|_| uniform()), uniform())).collect()
}

fn measure<T: Scalar, const N: usize>(
    c: &mut Criterion,
    name: &str,
    mut update: impl FnMut(&[T; N], T),
) {
    let samples = samples::<T, N>();
    let mut group = c.benchmark_group(format!("rls update, n = {N}"));
    group.throughput(Throughput::Elements(UPDATES as u64));
    group.bench_function(name, |b| {
        b.iter(|| {
            for (phi, target) in &samples {
                update(phi, *target);
            }
        });
    });
    group.finish();
}

fn learn<T: Scalar, const N: usize>(c: &mut Criterion, name: &str, mut kernel: impl RlsKernel<T>) {
    let mut theta = [T::zero(); N];
    measure::<T, N>(c, name, |phi, target| kernel.update(phi, target, &mut theta));
    black_box(theta);
    // No sample was skipped, so that all of the work was done.
    assert_eq!(kernel.guard().skipped, 0);
}

fn scalar<T: Scalar, const N: usize>(c: &mut Criterion, scalar: &str) {
    let design = design();
    let name = |form: &str| format!("{form} {scalar}");
    learn::<T, N>(c, &name("UD fixed"), UdRls::<T, Static<N>>::new(N, &design).unwrap());
    learn::<T, N>(c, &name("UD heap"), UdRls::<T, Heap>::new(N, &design).unwrap());
    learn::<T, N>(c, &name("P fixed"), ConventionalRls::<T, Static<N>>::new(N, &design).unwrap());
    learn::<T, N>(c, &name("P heap"), ConventionalRls::<T, Heap>::new(N, &design).unwrap());
    learn::<T, N>(c, &name("QR fixed"), QrRls::<T, Static<N>>::new(N, &design).unwrap());
}

fn peers<const N: usize>(c: &mut Criterion) {
    let mut filter = RlsFilter::<f64, N>::new(LAMBDA, PRIOR).unwrap();
    measure::<f64, N>(c, "oxictl RlsFilter f64", |phi, target| {
        black_box(filter.update(phi, target).unwrap());
    });
    let mut filter = RlsFilter::<f32, N>::new(0.999, 1e2).unwrap();
    measure::<f32, N>(c, "oxictl RlsFilter f32", |phi, target| {
        black_box(filter.update(phi, target).unwrap());
    });
    let mut rls = OxictlRls::<f64, N>::new(LAMBDA, PRIOR);
    measure::<f64, N>(c, "oxictl Rls f64", |phi, target| {
        black_box(rls.update(phi, target));
    });
    let mut filter = KalmanFilter::<f64>::new(N, 0.0, 1.0, PRIOR);
    measure::<f64, N>(c, "dsmc KalmanFilter f64", |phi, target| {
        filter.update(phi, target);
        black_box(&filter.parameter);
    });
}

fn sizes<const N: usize>(c: &mut Criterion) {
    scalar::<f64, N>(c, "f64");
    scalar::<f32, N>(c, "f32");
    peers::<N>(c);
}

fn block<T: LaneScalar>(n: usize, (estimators, steps): (usize, usize)) -> SampleBlock<T> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(n as u64);
    let mut block = SampleBlock::new(n, estimators, steps);
    let mut phi = vec![T::zero(); n];
    for estimator in 0..estimators {
        for step in 0..steps {
            for phi in &mut phi {
                *phi = T::from_design(rng.random_range(-1.0..1.0));
            }
            block.set(estimator, step, &phi, T::from_design(rng.random_range(-1.0..1.0)));
        }
    }
    block
}

fn batches<T: LaneScalar>(c: &mut Criterion, scalar: &str) {
    let (estimators, steps) = BATCH;
    for n in [2, 5, 10, 20] {
        let block = block::<T>(n, BATCH);
        let mut group = c.benchmark_group(format!("rls batch, n = {n}"));
        group.throughput(Throughput::Elements((estimators * steps) as u64));
        for machine in Machine::all() {
            let mut batch = BatchRls::<T>::new(n, estimators, &design()).unwrap().on(machine);
            group.bench_function(format!("{scalar} {machine}"), |b| {
                b.iter(|| batch.update(&block).unwrap());
            });
        }
        group.finish();
    }
}

fn fleet<T: LaneScalar>(c: &mut Criterion, scalar: &str) {
    let (estimators, steps) = FLEET;
    let block = block::<T>(5, FLEET);
    let mut fleet = BatchRls::<T>::new(5, estimators, &design()).unwrap();
    let mut group = c.benchmark_group("rls fleet of 1000000, n = 5");
    group.throughput(Throughput::Elements((estimators * steps) as u64));
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    group.bench_function(format!("{scalar}, one core"), |b| {
        b.iter(|| fleet.update(&block).unwrap());
    });
    let two = ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    group.bench_function(format!("{scalar}, two cores"), |b| {
        b.iter(|| two.install(|| fleet.update_on_all_cores(&block).unwrap()));
    });
    group.finish();
}

fn side_by_side(c: &mut Criterion) {
    batches::<f64>(c, "f64");
    batches::<f32>(c, "f32");
    // Two cores in cache: so many tiles that each core takes its own.
    let many = (4096, 16);
    let block = block::<f64>(5, many);
    let mut batch = BatchRls::<f64>::new(5, many.0, &design()).unwrap();
    let mut group = c.benchmark_group("rls batch of 4096, n = 5");
    group.throughput(Throughput::Elements((many.0 * many.1) as u64));
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        group.bench_function(format!("f64, threads: {threads}"), |b| {
            b.iter(|| pool.install(|| batch.update_on_all_cores(&block).unwrap()));
        });
    }
    group.finish();
    fleet::<f64>(c, "f64");
    fleet::<f32>(c, "f32");
}

/// Fused multiply-adds per second, counted per lane.
fn limit(c: &mut Criterion) {
    let mut group = c.benchmark_group("fused multiply-adds");
    for (name, run) in fused_multiply_adds() {
        let count = run();
        group.throughput(Throughput::Elements(count));
        group.bench_function(name, |b| b.iter(run));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(SAMPLES)
        .warm_up_time(WARM_UP)
        .measurement_time(MEASUREMENT);
    targets = limit, sizes::<2>, sizes::<5>, sizes::<10>, sizes::<20>, side_by_side
}
criterion_main!(benches);
