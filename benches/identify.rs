//! How long does it take to learn the bias from 1200 samples, and to choose its order?
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use criterion::{Criterion, criterion_group, criterion_main};
use fdiag::ident::{
    arx::{ArxFit, ArxOrders},
    least_squares::LeastSquares,
    order::{all_orders, paper_orders, select_orders},
    refine::Prefilter,
};
use fdiag_benches::{MEASUREMENT, PaperCase, SAMPLES, WARM_UP};

fn fits(c: &mut Criterion) {
    let residual = PaperCase::new().unwrap().residual;
    let plain = ArxFit::new(ArxOrders::paper(2));
    let low_pass = Prefilter::low_pass(2, 8.0, residual.ts()).unwrap();
    let filtered = plain.clone().with_prefilter(low_pass);
    let mut group = c.benchmark_group("fit, 1200 samples");
    group.bench_function("n = 2", |b| b.iter(|| plain.fit(&[&residual]).unwrap()));
    group.bench_function("n = 2, prefiltered", |b| b.iter(|| filtered.fit(&[&residual]).unwrap()));
    group.finish();
}

fn orders(c: &mut Criterion) {
    let residual = PaperCase::new().unwrap().residual;
    let (training, held_out) = (residual.slice(0, 900), residual.slice(900, 1200));
    let mut group = c.benchmark_group("order selection, 1200 samples");
    // Fits alone: sharing one factorisation, and each with a solver of its own, which a stated
    // tolerance asks for.
    let alone = LeastSquares::new().with_rank_tolerance(1e-12);
    for (name, solver) in [("shared", LeastSquares::new()), ("separate", alone)] {
        group.bench_function(format!("216 orders, fits {name}"), |b| {
            b.iter(|| select_orders(&all_orders(5), &solver, &[&training], &[]).unwrap());
        });
    }
    for candidates in [paper_orders(5), all_orders(5)] {
        group.bench_function(format!("{} orders", candidates.len()), |b| {
            let solver = LeastSquares::new();
            b.iter(|| select_orders(&candidates, &solver, &[&training], &[&held_out]).unwrap());
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(SAMPLES)
        .warm_up_time(WARM_UP)
        .measurement_time(MEASUREMENT);
    targets = fits, orders
}
criterion_main!(benches);
