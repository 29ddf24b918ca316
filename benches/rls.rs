//! What does one update of recursive least squares cost, by number of parameters?
//!
//! `UD` is the default factorisation, `P` the conventional covariance form; on the stack (`fixed`)
//! or on the heap.
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fdiag::{
    core::{Heap, Scalar},
    ident::rls::{ConventionalRls, RlsDesign, RlsKernel, Static, UdRls},
};
use fdiag_benches::{MEASUREMENT, SAMPLES, WARM_UP};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Updates from the prior on, after which the estimator starts again.
const UPDATES: usize = 256;

fn learn<T: Scalar, K: RlsKernel<T>>(c: &mut Criterion, name: &str, mut kernel: K) {
    let n = kernel.parameters();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(n as u64);
    let mut uniform = || T::from_design(rng.random_range(-1.0..1.0));
    let phi: Vec<T> = (0..UPDATES * n).map(|_| uniform()).collect();
    let target: Vec<T> = (0..UPDATES).map(|_| uniform()).collect();
    let mut theta = vec![T::zero(); n];
    let mut group = c.benchmark_group(format!("rls update, n = {n}"));
    group.throughput(Throughput::Elements(UPDATES as u64));
    group.bench_function(name, |b| {
        b.iter(|| {
            kernel.reset();
            theta.fill(T::zero());
            for (phi, &target) in phi.chunks_exact(n).zip(&target) {
                kernel.update(phi, target, &mut theta);
            }
            theta[0]
        });
    });
    group.finish();
    // No sample was skipped, so that all of the work was done.
    assert_eq!(kernel.guard().skipped, 0);
}

fn scalar<T: Scalar, const N: usize>(c: &mut Criterion, scalar: &str) {
    // Both forms are benched in both scalars, so the prior is one that f32 can hold in either.
    let design = RlsDesign { prior_variance: 1e2, ..RlsDesign::default() };
    let ud = (
        UdRls::<T, Static<N>>::new(N, &design).unwrap(),
        UdRls::<T, Heap>::new(N, &design).unwrap(),
    );
    let conventional = (
        ConventionalRls::<T, Static<N>>::new(N, &design).unwrap(),
        ConventionalRls::<T, Heap>::new(N, &design).unwrap(),
    );
    learn(c, &format!("UD fixed {scalar}"), ud.0);
    learn(c, &format!("UD heap {scalar}"), ud.1);
    learn(c, &format!("P fixed {scalar}"), conventional.0);
    learn(c, &format!("P heap {scalar}"), conventional.1);
}

fn sizes<const N: usize>(c: &mut Criterion) {
    scalar::<f64, N>(c, "f64");
    scalar::<f32, N>(c, "f32");
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(SAMPLES)
        .warm_up_time(WARM_UP)
        .measurement_time(MEASUREMENT);
    targets = sizes::<2>, sizes::<5>, sizes::<10>, sizes::<20>
}
criterion_main!(benches);
