//! Estimators side by side do what each of them would do alone.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::noise;
use fd_core::{
    Snapshot,
    stage::{Identifier, Stage},
};
use fd_ident::{
    arx::{ArxOrders, RecursiveArx},
    batch::{BatchError, BatchRls, BatchScalar, Machine, SampleBlock},
    rls::{Forgetting, Guard, RlsDesign, RlsKernel, UdRls},
};
use proptest::prelude::*;

/// One stream of samples per estimator; `None` where a sample is missing.
type Streams<T> = Vec<Vec<Option<(Vec<T>, T)>>>;

/// Samples of `y = φᵀθ + e` with θ = (1, 2, …, n); every 13th is missing.
fn streams<T: BatchScalar>(n: usize, count: usize, steps: usize, seed: u64) -> Streams<T> {
    let t = T::from_design;
    (0..count as u64)
        .map(|unit| {
            let numbers = noise(seed * 1000 + unit, steps * (n + 1));
            (0_u64..)
                .zip(numbers.chunks_exact(n + 1))
                .map(|(k, row)| {
                    let theta = (1..).map(f64::from);
                    let y = row[..n].iter().zip(theta).map(|(a, b)| a * b).sum::<f64>();
                    let phi = row[..n].iter().map(|&v| t(v)).collect();
                    ((k + unit) % 13 != 5).then_some((phi, t(y + 0.1 * row[n])))
                })
                .collect()
        })
        .collect()
}

fn blocks<T: BatchScalar>(n: usize, streams: &Streams<T>, length: usize) -> Vec<SampleBlock<T>> {
    let steps = streams[0].len();
    (0..steps.div_ceil(length))
        .map(|b| {
            let now = b * length..steps.min((b + 1) * length);
            let mut block = SampleBlock::new(n, streams.len(), now.len());
            for (unit, stream) in streams.iter().enumerate() {
                for (k, sample) in stream[now.clone()].iter().enumerate() {
                    if let Some((phi, y)) = sample {
                        block.set(unit, k, phi, *y);
                    }
                }
            }
            block
        })
        .collect()
}

/// Forgetting that differs from lane to lane.
fn designs(count: usize, prior_variance: f64, guard: Guard) -> Vec<RlsDesign> {
    let kinds = [
        Forgetting::None,
        Forgetting::Equation18 { alpha: 0.3, falling: None },
        Forgetting::Exponential { lambda: 0.9 },
        Forgetting::Exponential { lambda: 0.99 },
        Forgetting::Exponential { lambda: 0.999 },
        Forgetting::Directional { lambda: 0.98 },
    ];
    let design = |unit: usize| RlsDesign { prior_variance, forgetting: kinds[unit % 6], guard };
    (0..count).map(design).collect()
}

fn alone<T: BatchScalar>(
    n: usize,
    design: &RlsDesign,
    stream: &[Option<(Vec<T>, T)>],
) -> (Vec<T>, Vec<T>, fd_core::stage::GuardReport) {
    let mut rls = UdRls::<T>::new(n, design).unwrap();
    let mut theta = vec![T::zero(); n];
    let nan = T::zero() / T::zero();
    for sample in stream {
        match sample {
            Some((phi, y)) => rls.update(phi, *y, &mut theta),
            None => rls.update(&vec![nan; n], nan, &mut theta),
        }
    }
    let mut variance = vec![T::zero(); n];
    rls.variance_into(&mut variance);
    (theta, variance, rls.guard())
}

/// Largest relative distance between two vectors.
fn distance<T: BatchScalar>(a: &[T], b: &[T]) -> f64 {
    let size = b.iter().map(|b| b.to_report().abs()).fold(0.0, f64::max);
    let error = a.iter().zip(b).map(|(&a, &b)| (a - b).to_report().abs()).fold(0.0, f64::max);
    error / size.max(f64::MIN_POSITIVE)
}

fn compare<T: BatchScalar>(n: usize, count: usize, steps: usize, length: usize, seed: u64) {
    let streams = streams::<T>(n, count, steps, seed);
    let designs = designs(count, 100.0, Guard::default());
    for machine in Machine::all() {
        let mut batch = BatchRls::new(n, count, &designs[0]).unwrap().on(machine);
        for (unit, design) in designs.iter().enumerate() {
            batch.redesign(unit, design).unwrap();
        }
        for block in &blocks(n, &streams, length) {
            batch.update(block).unwrap();
        }
        for (unit, (design, stream)) in designs.iter().zip(&streams).enumerate() {
            let (theta, variance, guard) = alone(n, design, stream);
            let (mut found, mut spread) = (theta.clone(), theta.clone());
            batch.theta_into(unit, &mut found);
            batch.variance_into(unit, &mut spread);
            // Uniform regressors in n dimensions from a prior of 100: the weighted regressors have
            // a condition κ of at most some hundred while samples are few, and the errors of both
            // forms are a few n ε each.
            let tolerance = T::default_epsilon().to_report() * 20.0 * n as f64 * 1e3;
            let (of_theta, of_variance) = (distance(&found, &theta), distance(&spread, &variance));
            assert!(of_theta < tolerance, "{machine}, {unit}, {design:?}: theta {of_theta:e}");
            assert!(of_variance < tolerance, "{machine}, {unit}: variance {of_variance:e}");
            assert_eq!(batch.guard(unit), guard, "{machine}, {unit}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn side_by_side_as_alone(
        n in 1_usize..12, count in 1_usize..40, steps in 1_usize..120, length in 1_usize..50,
        seed in 0_u64..1000,
    ) {
        compare::<f64>(n, count, steps, length, seed);
        compare::<f32>(n, count, steps, length, seed);
    }
}

#[test]
fn more_parameters_than_are_unrolled() {
    for n in [16, 17, 33, 64] {
        compare::<f64>(n, 9, 150, 64, 1);
    }
}

/// Excitation stops, so that the safeguards act: in the same samples as for one estimator alone.
#[test]
fn safeguards_act_as_alone() {
    let n = 3;
    let count = 20;
    let mut streams = streams::<f64>(n, count, 3000, 7);
    for stream in &mut streams {
        for sample in stream[300..].iter_mut().flatten() {
            sample.0 = vec![1.0, 0.5, 0.0];
        }
        for sample in stream[2000..2100].iter_mut().flatten() {
            sample.0 = vec![0.0; 3];
        }
    }
    let designs = designs(count, 1.0, Guard { trace_limit: 2.0, ..Guard::default() });
    let mut batch = BatchRls::new(n, count, &designs[0]).unwrap();
    for (unit, design) in designs.iter().enumerate() {
        batch.redesign(unit, design).unwrap();
    }
    for block in &blocks(n, &streams, 50) {
        batch.update(block).unwrap();
    }
    let (mut theta, mut variance) = (vec![0.0; n], vec![0.0; n]);
    for (unit, (design, stream)) in designs.iter().zip(&streams).enumerate() {
        let (expected, spread, guard) = alone(n, design, stream);
        batch.theta_into(unit, &mut theta);
        batch.variance_into(unit, &mut variance);
        let found = batch.guard(unit);
        assert_eq!(found.skipped, guard.skipped);
        assert!(guard.skipped >= 100);
        // Whether the trace is above its limit is decided within rounding of the limit.
        assert!(found.bounded.abs_diff(guard.bounded) <= guard.bounded / 50, "{unit}: {found:?}");
        if matches!(design.forgetting, Forgetting::Exponential { lambda } if lambda < 0.995) {
            assert!(guard.bounded > 500, "{guard:?}");
        }
        // A decision the other way moves P by 1 − λ, in directions that the samples do not show.
        let tolerance = if found == guard { 1e-9 } else { 0.2 };
        assert!(distance(&theta, &expected) < tolerance, "{unit}: {theta:?} {expected:?}");
        assert!(distance(&variance, &spread) < tolerance, "{unit}: {variance:?} {spread:?}");
    }
}

/// Directional forgetting that its trace limit stops, and not, next to other kinds.
#[test]
fn directional_forgetting_pauses_as_alone() {
    let (n, count) = (3, 19);
    let streams = streams::<f64>(n, count, 300, 5);
    let mut paused = 0;
    for trace_limit in [1.0, 10.0] {
        // So little is left to learn that most samples are forgotten faster than they come.
        let guard = Guard { trace_limit, ..Guard::default() };
        let designs: Vec<_> = [0.9, 0.95, 0.99]
            .into_iter()
            .flat_map(|lambda| {
                [Forgetting::Directional { lambda }, Forgetting::Exponential { lambda }]
            })
            .map(|forgetting| RlsDesign { prior_variance: 0.01, forgetting, guard })
            .cycle()
            .take(count)
            .collect();
        let mut batch = BatchRls::new(n, count, &designs[0]).unwrap();
        for (unit, design) in designs.iter().enumerate() {
            batch.redesign(unit, design).unwrap();
        }
        for block in &blocks(n, &streams, 30) {
            batch.update(block).unwrap();
        }
        let (mut theta, mut variance) = (vec![0.0; n], vec![0.0; n]);
        for (unit, (design, stream)) in designs.iter().zip(&streams).enumerate().step_by(2) {
            let (expected, spread, guard) = alone(n, design, stream);
            batch.theta_into(unit, &mut theta);
            batch.variance_into(unit, &mut variance);
            assert_eq!(batch.guard(unit), guard, "{unit}, {design:?}");
            assert!(distance(&theta, &expected) < 1e-11, "{unit}: {theta:?} {expected:?}");
            assert!(distance(&variance, &spread) < 1e-11, "{unit}: {variance:?} {spread:?}");
            paused += guard.bounded;
        }
    }
    assert!(paused > 100, "{paused}");
}

/// Lanes that forget in another way do not notice, to the bit.
#[test]
fn directional_neighbours_change_nothing() {
    let streams = streams::<f32>(5, 16, 200, 8);
    let blocks = blocks(5, &streams, 50);
    let exponential = RlsDesign::forgetting(Forgetting::Exponential { lambda: 0.97 });
    let directional = RlsDesign::forgetting(Forgetting::Directional { lambda: 0.97 });
    let mut plain = BatchRls::<f32>::new(5, 16, &exponential).unwrap();
    let mut mixed = plain.clone();
    mixed.redesign(3, &directional).unwrap();
    for block in &blocks {
        plain.update(block).unwrap();
        mixed.update(block).unwrap();
    }
    for unit in 0..16 {
        let (mut a, mut b) = ([0.0; 5], [0.0; 5]);
        plain.theta_into(unit, &mut a);
        mixed.theta_into(unit, &mut b);
        assert_eq!(a.map(f32::to_bits) == b.map(f32::to_bits), unit != 3);
    }
}

#[test]
fn frozen_estimators_keep_everything() {
    let streams = streams::<f32>(4, 21, 80, 3);
    let blocks = blocks(4, &streams, 40);
    let design = RlsDesign::forgetting(Forgetting::Exponential { lambda: 0.98 });
    let mut batch = BatchRls::<f32>::new(4, 21, &design).unwrap();
    batch.update(&blocks[0]).unwrap();
    let state = |batch: &BatchRls<f32>, unit| {
        let (mut theta, mut variance) = ([0.0; 4], [0.0; 4]);
        batch.theta_into(unit, &mut theta);
        batch.variance_into(unit, &mut variance);
        (theta.map(f32::to_bits), variance.map(f32::to_bits), batch.guard(unit))
    };
    batch.freeze(5, true);
    let before: Vec<_> = (0..21).map(|unit| state(&batch, unit)).collect();
    batch.update(&blocks[1]).unwrap();
    for (unit, before) in before.iter().enumerate() {
        assert_eq!(state(&batch, unit) == *before, unit == 5);
    }
    batch.freeze(5, false);
    batch.update(&blocks[1]).unwrap();
    assert_ne!(state(&batch, 5), before[5]);
}

#[test]
fn cores_blocks_and_snapshots_change_nothing() {
    let streams = streams::<f64>(5, 1200, 64, 9);
    let design = RlsDesign::forgetting(Forgetting::Exponential { lambda: 0.95 });
    let mut one = BatchRls::<f64>::new(5, 1200, &design).unwrap();
    let (mut cores, mut restored) = (one.clone(), one.clone());
    for block in &blocks(5, &streams, 64) {
        one.update(block).unwrap();
    }
    let expected = Snapshot::of(&mut one);
    let short = blocks(5, &streams, 16);
    for (k, block) in short.iter().enumerate() {
        cores.update_on_all_cores(block).unwrap();
        if k == 1 {
            Snapshot::of(&mut cores).restore(&mut restored).unwrap();
        } else if k > 1 {
            restored.update(block).unwrap();
        }
    }
    assert_eq!(Snapshot::of(&mut cores), expected);
    assert_eq!(Snapshot::of(&mut restored), expected);
    let new = Snapshot::of(&mut BatchRls::<f64>::new(5, 1200, &design).unwrap());
    one.reset();
    assert_eq!(Snapshot::of(&mut one), new);
}

#[test]
fn refusals() {
    let design = RlsDesign::default();
    let most = BatchRls::<f64>::new(65, 3, &design).unwrap_err();
    assert_eq!(most, BatchError::Parameters { most: 64, found: 65 });
    let bounded = RlsDesign::forgetting(Forgetting::Bounded { lambda: 0.9, variance: 1.0 });
    let kind = BatchRls::<f64>::new(2, 3, &bounded).unwrap_err();
    assert_eq!(kind, BatchError::Forgetting { found: "bounded" });
    let bad = RlsDesign::forgetting(Forgetting::Exponential { lambda: 1.5 });
    assert!(matches!(BatchRls::<f64>::new(2, 3, &bad), Err(BatchError::Design(_))));
    let mut batch = BatchRls::<f64>::new(2, 3, &design).unwrap();
    let other = batch.update(&SampleBlock::new(2, 4, 1)).unwrap_err();
    assert_eq!(other, BatchError::Block { what: "estimators", expected: 3, found: 4 });
    // Nobody there, nothing to learn.
    batch.update(&SampleBlock::new(2, 3, 0)).unwrap();
    let mut nobody = BatchRls::<f64>::new(2, 0, &design).unwrap();
    nobody.update(&SampleBlock::new(2, 0, 5)).unwrap();
}

/// Estimators that make their regressors themselves learn what `RecursiveArx` learns.
#[test]
fn difference_equations_side_by_side_as_alone() {
    let all = [
        ArxOrders::paper(2),
        ArxOrders::new(0, 2, 0),
        ArxOrders::new(3, 0, 0),
        ArxOrders::new(1, 2, 3).with_offset(),
    ];
    for (orders, nu) in all.into_iter().flat_map(|orders| [(orders, 1), (orders, 2)]) {
        let (count, steps) = (11, 90);
        let design = RlsDesign {
            prior_variance: 100.0,
            ..RlsDesign::forgetting(Forgetting::Exponential { lambda: 0.98 })
        };
        let n = orders.parameters(nu);
        let signals: Vec<_> =
            (0..count as u64).map(|unit| noise(40 + unit, steps * (nu + 1))).collect();
        let mut batch = BatchRls::<f64>::arx(orders, nu, count, &design).unwrap();
        for start in (0..steps).step_by(30) {
            let mut block = SampleBlock::new(nu, count, 30);
            for (unit, signals) in signals.iter().enumerate() {
                let rows = signals.chunks_exact(nu + 1).skip(start).take(30);
                for (step, row) in rows.enumerate() {
                    block.set(unit, step, &row[..nu], row[nu]);
                }
            }
            batch.update(&block).unwrap();
        }
        let mut theta = vec![0.0; n];
        for (unit, signals) in signals.iter().enumerate() {
            let kernel = UdRls::<f64>::new(n, &design).unwrap();
            let mut alone = RecursiveArx::new(orders, nu, 1, kernel).unwrap();
            for row in signals.chunks_exact(nu + 1) {
                alone.update(&row[..nu], &row[nu..]);
            }
            batch.theta_into(unit, &mut theta);
            // As in `compare`.
            let tolerance = f64::EPSILON * 20.0 * n as f64 * 1e3;
            assert!(distance(&theta, alone.theta()) < tolerance, "{orders}, {nu} inputs");
            let skipped = alone.guard().skipped + orders.lag() as u64;
            assert_eq!(batch.guard(unit).skipped, skipped, "{orders}, {nu} inputs");
        }
    }
    let far = BatchRls::<f64>::arx(ArxOrders::new(2, 1, 40), 1, 3, &RlsDesign::default());
    assert_eq!(far.unwrap_err(), BatchError::Past { most: 32, found: 43 });
    // Room is for inputs and bias together.
    let arx = |na, nb| BatchRls::<f64>::arx(ArxOrders::new(na, nb, 0), 1, 3, &RlsDesign::default());
    assert!([(16, 16), (0, 32), (32, 0)].into_iter().all(|(na, nb)| arx(na, nb).is_ok()));
    for (na, nb) in [(16, 17), (0, 33), (33, 0)] {
        assert_eq!(arx(na, nb).unwrap_err(), BatchError::Past { most: 32, found: 33 });
    }
}
