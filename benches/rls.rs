//! What does one update of recursive least squares cost: alone, side by side, in a fleet?
//!
//! * Alone, by number of parameters: `UD` is the default factorisation, `P` the conventional
//!   covariance form, `QR` the reference; on the stack (`fixed`) or on the heap. Peers of other
//!   projects take the same samples.
//! * Side by side (`batch`): 64 estimators and 64 samples of each, which fit into a cache. Regressors
//!   are `given`, n + 1 numbers per sample, or `made` in the lanes from input and bias, 2 numbers.
//! * A fleet of a million estimators, which does not fit.
//! * On two cores: a fleet, and 4096 estimators whose samples stay in the shared cache. Beside them two
//!   threads that share nothing, each with half of the estimators: what the machine has to give.
//! * What the arithmetic of the machine would allow: fused multiply-adds per second.
//!
//! All forget by λ = 0.999, except `dsmc`, which has a random walk of variance zero instead.
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::{hint::black_box, thread, time::Instant};

use criterion::{
    BenchmarkGroup, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
    measurement::WallTime,
};
use dsmc::system_identification::kalman_filter::whitebox::KalmanFilter;
use fdiag::{
    core::{Heap, Scalar},
    ident::{
        arx::ArxOrders,
        batch::{BatchRls, BatchScalar, Machine, SampleBlock},
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
/// Enough work, half a millisecond and more, for the waking of a thread to count little.
const MANY: (usize, usize) = (4096, 256);
/// A block of samples is as long as its memory allows: 0.8 GB of f64 where regressors are given,
/// 1 GB where they are made.
const FLEET: usize = 1_000_000;
const STEPS_GIVEN: usize = 16;
const STEPS_MADE: usize = 64;

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

/// Uniform samples with this many columns besides the target.
fn block<T: BatchScalar>(columns: usize, (estimators, steps): (usize, usize)) -> SampleBlock<T> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(columns as u64);
    let mut uniform = || T::from_design(rng.random_range(-1.0..1.0));
    let mut block = SampleBlock::new(columns, estimators, steps);
    let mut sample = vec![T::zero(); columns];
    for estimator in 0..estimators {
        for step in 0..steps {
            sample.fill_with(&mut uniform);
            block.set(estimator, step, &sample, uniform());
        }
    }
    block
}

/// Estimators whose n regressors are given, and samples for them.
fn given<T: BatchScalar>(
    n: usize,
    size: (usize, usize),
    design: &RlsDesign,
) -> (BatchRls<T>, SampleBlock<T>) {
    (BatchRls::new(n, size.0, design).unwrap(), block(n, size))
}

/// Estimators of the paper's equation of order 2, n = 5, that make their regressors from one input
/// and the bias, and samples for them.
fn made<T: BatchScalar>(size: (usize, usize)) -> (BatchRls<T>, SampleBlock<T>) {
    (BatchRls::arx(ArxOrders::paper(2), 1, size.0, &design()).unwrap(), block(1, size))
}

fn updates(group: &mut BenchmarkGroup<'_, WallTime>, (estimators, steps): (usize, usize)) {
    group.throughput(Throughput::Elements((estimators * steps) as u64));
}

fn batches<T: BatchScalar>(c: &mut Criterion, scalar: &str) {
    for n in [2, 5, 10, 20] {
        let (batch, block) = given::<T>(n, BATCH, &design());
        let mut group = c.benchmark_group(format!("rls batch, n = {n}"));
        updates(&mut group, BATCH);
        for machine in Machine::all() {
            let mut batch = batch.clone().on(machine);
            group.bench_function(format!("{scalar} {machine}"), |b| {
                b.iter(|| batch.update(&block).unwrap());
            });
        }
        group.finish();
    }
    let mut group = c.benchmark_group("rls batch of equations, n = 5");
    updates(&mut group, BATCH);
    let (mut batch, block) = made::<T>(BATCH);
    group.bench_function(scalar, |b| b.iter(|| batch.update(&block).unwrap()));
    group.finish();
    // What keeps an estimate when excitation stops.
    let mut group = c.benchmark_group("rls batch, directional, n = 5");
    updates(&mut group, BATCH);
    let forgetting = Forgetting::Directional { lambda: LAMBDA };
    let (mut batch, block) = given::<T>(5, BATCH, &RlsDesign { forgetting, ..design() });
    group.bench_function(scalar, |b| b.iter(|| batch.update(&block).unwrap()));
    group.finish();
}

/// The same work on one core, on two, and by two threads that share nothing.
fn cores<T: BatchScalar>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    size: (usize, usize),
    make: impl Fn((usize, usize)) -> (BatchRls<T>, SampleBlock<T>),
) {
    let (mut batch, block) = make(size);
    updates(group, size);
    group.bench_function(format!("{name}, one core"), |b| {
        b.iter(|| batch.update(&block).unwrap());
    });
    let two = ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    group.bench_function(format!("{name}, two cores"), |b| {
        // From within, so that only one thread has to be woken.
        two.install(|| b.iter(|| batch.update_on_all_cores(&block).unwrap()));
    });
    drop((batch, block));
    let mut halves = [make((size.0 / 2, size.1)), make((size.0 / 2, size.1))];
    group.bench_function(format!("{name}, two threads apart"), |b| {
        b.iter_custom(|passes| {
            let start = Instant::now();
            thread::scope(|scope| {
                for (batch, block) in &mut halves {
                    scope.spawn(move || (0..passes).for_each(|_| batch.update(block).unwrap()));
                }
            });
            start.elapsed()
        });
    });
}

fn on_cores<T: BatchScalar>(c: &mut Criterion, scalar: &str) {
    let mut group = c.benchmark_group("rls batch of 4096, n = 5");
    cores(&mut group, scalar, MANY, made::<T>);
    group.finish();
    let mut group = c.benchmark_group("rls fleet of 1000000, n = 5");
    // A pass takes a quarter of a second: the fewest passes that criterion allows.
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    cores(&mut group, &format!("{scalar} given"), (FLEET, STEPS_GIVEN), |size| {
        given::<T>(5, size, &design())
    });
    cores(&mut group, &format!("{scalar} made"), (FLEET, STEPS_MADE), made::<T>);
    group.finish();
}

fn side_by_side(c: &mut Criterion) {
    batches::<f64>(c, "f64");
    batches::<f32>(c, "f32");
    on_cores::<f64>(c, "f64");
    on_cores::<f32>(c, "f32");
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
