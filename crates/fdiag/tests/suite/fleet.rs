//! A fleet answers as that many pipelines would, however its samples are divided, and stands missing
//! ones.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::support::nominal;
use fdiag::{
    compensate::{
        decide::{Debounce, Debouncing},
        detect::Magnitude,
        residual_compensation::{
            CompensationPlan, Convergence, HardFault, OperatingPoint, RangePolicy,
            ResidualCompensator, Trial,
        },
    },
    core::{
        Heap, IoDims, Pipeline, Snapshot, Stages,
        stage::{Phase, Stage},
    },
    fleet::{Fleet, FleetBlock, FleetDesign, FleetError, FleetScalar},
    ident::{
        arx::{ArxOrders, ArxSimulator, RecursiveArx},
        rls::{Forgetting, RlsDesign, UdRls},
    },
    residual::observer::ObserverDesign,
};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const TRAINING: u64 = 250;
const IO: IoDims = IoDims { nu: 1, ny: 2 };

type Design = FleetDesign<Magnitude<f64>, Debounce>;

fn design(orders: ArxOrders) -> Design {
    let observer = ObserverDesign::faster(&nominal(), 2.0).unwrap();
    FleetDesign {
        generator: observer.form().unwrap(),
        orders,
        learning: RlsDesign::forgetting(Forgetting::Exponential { lambda: 0.999 }),
        settling: 0,
        training: TRAINING,
        detector: Magnitude::new(&[1.0, 2.0], 0.05).unwrap(),
        rule: Debounce::new(2, Debouncing::consecutive(3)).unwrap(),
    }
}

/// A pipeline whose training is as long as that of a fleet and that does nothing else on its own.
fn pipeline(design: &Design) -> impl FnMut(&[f64], &[f64]) -> (Vec<f64>, Phase, bool) + use<> {
    let FleetDesign { generator, orders, learning, detector, rule, .. } = design.clone();
    let (nu, channels) = (generator.io().nu, generator.residual_len());
    let kernel = UdRls::<f64>::new(orders.parameters(nu), &learning).unwrap();
    let plan = CompensationPlan {
        convergence: Convergence {
            tolerance: 1e300,
            consecutive: 1,
            // Samples before the past is full are counted as learned by a pipeline.
            least_samples: TRAINING + orders.lag() as u64,
            ..Convergence::default()
        },
        trial: Trial { samples: 0, divergence: 1e300, ..Trial::default() },
        hard_fault: HardFault { watch: false, ..HardFault::default() },
        operating_point: OperatingPoint {
            policy: RangePolicy::Ignore,
            ..OperatingPoint::default()
        },
        ..CompensationPlan::default()
    };
    let compensator = ResidualCompensator::new(
        RecursiveArx::new(orders, nu, channels, kernel).unwrap(),
        ArxSimulator::new(orders, nu, channels).unwrap(),
        &plan,
    );
    let generator = generator.freeze::<f64, Heap, Heap>().unwrap();
    let stages = Stages { generator, compensator: compensator.unwrap(), detector, rule };
    let mut pipeline = Pipeline::new(stages).unwrap();
    move |u, y| {
        let step = pipeline.step(u, y).unwrap();
        (step.compensated.to_vec(), step.phase, step.decision.is_fault())
    }
}

/// Samples of a unit whose plant is not quite the model, with a fault late in every third unit.
fn samples(unit: usize, steps: usize) -> Vec<([f64; 1], [f64; 2])> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(unit as u64);
    let slow = rng.random_range(0.915..0.925);
    let (mut x, mut u) = ([0.0; 2], 0.0);
    (0..steps)
        .map(|k| {
            if k.is_multiple_of(7) {
                u = rng.random_range(-1.0..1.0);
            }
            let fault = if unit.is_multiple_of(3) && k > 2 * steps / 3 { 0.5 } else { 0.0 };
            let noise = [(); 2].map(|()| rng.random_range(-1e-3..1e-3));
            let y = [x[0] + noise[0] + fault, 0.3 * x[0] + x[1] + noise[1]];
            x = [slow * x[0] + 0.05 * x[1] + 0.05 * u, -0.03 * x[0] + 0.85 * x[1] + 0.12 * u];
            ([u], y)
        })
        .collect()
}

fn block<T: FleetScalar>(units: &[Vec<([f64; 1], [f64; 2])>], steps: [usize; 2]) -> FleetBlock<T> {
    let [first, end] = steps;
    let mut block = FleetBlock::new(IO, units.len(), end - first);
    let convert = |row: &[f64]| -> Vec<T> {
        row.iter().map(|&v| <T as fdiag::core::Scalar>::from_design(v)).collect()
    };
    for (unit, samples) in units.iter().enumerate() {
        for (step, (u, y)) in samples[first..end].iter().enumerate() {
            block.set(unit, step, &convert(u), &convert(y));
        }
    }
    block
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    /// Same bias, same residuals, same alarms; blocks end anywhere.
    #[test]
    fn a_fleet_is_so_many_pipelines(
        units in 1_usize..300,
        cuts in proptest::collection::vec(1_usize..599, 0..6),
        (na, nb, delay, offset) in (0_usize..3, 1_usize..3, 0_usize..3, any::<bool>()),
    ) {
        let steps = 600;
        let orders = ArxOrders { na, nb, delay, offset };
        let design = design(orders);
        let units: Vec<_> = (0..units).map(|unit| samples(unit, steps)).collect();
        let mut fleet = Fleet::<f64, _, _>::new(&design, units.len()).unwrap();
        let mut cuts = [&[0], &cuts[..], &[steps]].concat();
        cuts.sort_unstable();
        cuts.dedup();
        let mut pipelines: Vec<_> = units.iter().map(|_| pipeline(&design)).collect();
        for pair in cuts.windows(2) {
            fleet.update_on_all_cores(&block(&units, [pair[0], pair[1]])).unwrap();
            for (i, (unit, pipeline)) in units.iter().zip(&mut pipelines).enumerate() {
                let mut last = (Vec::new(), Phase::Compensating, false);
                for (u, y) in &unit[pair[0]..pair[1]] {
                    last = pipeline(u, y);
                }
                let (status, mut r_star) = (fleet.unit(i), [0.0; 2]);
                fleet.compensated_into(i, &mut r_star);
                // The sample at which the switch opens is still one of training for a pipeline.
                if matches!(last.1, Phase::Compensating) {
                    prop_assert_eq!(status.phase, Phase::Compensating);
                    // Sums are ordered otherwise: some n ε κ of the regressors in the parameters,
                    // which are then simulated; 1e-9 leaves room for a condition of 1e5.
                    for (found, expected) in r_star.iter().zip(&last.0) {
                        let most = 1e-9 * (1.0 + expected.abs());
                        prop_assert!((found - expected).abs() < most, "{found} {expected}");
                    }
                    prop_assert_eq!(status.decision.is_fault(), last.2, "unit {}", i);
                }
                prop_assert_eq!(status.samples, pair[1] as u64);
            }
        }
        let faults = (0..units.len()).filter(|&i| fleet.unit(i).decision.is_fault()).count();
        prop_assert!(faults > 0, "the comparison has seen no fault");
    }
}

#[test]
fn cores_resets_and_snapshots_change_nothing() {
    let design = design(ArxOrders::paper(2));
    let units: Vec<_> = (0..200).map(|unit| samples(unit, 500)).collect();
    let [early, late] = [block::<f32>(&units, [0, 300]), block::<f32>(&units, [300, 500])];
    let single = FleetDesign {
        detector: Magnitude::<f32>::new(&[1.0, 2.0], 0.05).unwrap(),
        rule: design.rule.clone(),
        generator: design.generator.clone(),
        orders: design.orders,
        learning: RlsDesign { prior_variance: 1e2, ..design.learning },
        settling: design.settling,
        training: design.training,
    };
    let mut fleet = Fleet::<f32, _, _>::new(&single, 200).unwrap();
    fleet.update(&early).unwrap();
    let snapshot = Snapshot::of(&mut fleet);
    fleet.update(&late).unwrap();
    let end = Snapshot::of(&mut fleet);

    fleet.reset();
    fleet.update_on_all_cores(&early).unwrap();
    assert_eq!(Snapshot::of(&mut fleet), snapshot);
    let mut other = Fleet::<f32, _, _>::new(&single, 200).unwrap();
    snapshot.restore(&mut other).unwrap();
    other.update(&late).unwrap();
    assert_eq!(Snapshot::of(&mut other), end);
    let faults = (0..200).filter(|&unit| other.unit(unit).decision.is_fault()).count();
    assert!((30..80).contains(&faults), "67 units are faulty, {faults} alarmed");
}

/// Gaps: nothing is learned from them or judged, and other units do not notice.
#[test]
fn missing_samples_are_held_and_counted() {
    let design = FleetDesign { settling: 20, ..design(ArxOrders::paper(2)) };
    let units: Vec<_> = (0..40).map(|unit| samples(unit, 700)).collect();
    let mut whole = Fleet::<f64, _, _>::new(&design, 40).unwrap();
    let whole_block = block::<f64>(&units, [0, 700]);
    whole.update(&whole_block).unwrap();

    let mut gaps = whole_block.clone();
    for step in (100..200).step_by(9).chain(500..505) {
        let (u, y) = units[5][step];
        gaps.set(5, step, &u, &[f64::NAN, y[1]]);
        gaps.set(6, step, &[f64::INFINITY], &units[6][step].1);
    }
    // Nothing ever comes from unit 7.
    (0..700).for_each(|step| gaps.set(7, step, &[f64::NAN], &[f64::NAN; 2]));
    let mut fleet = Fleet::<f64, _, _>::new(&design, 40).unwrap();
    fleet.update(&gaps).unwrap();

    let missing = (100..200).step_by(9).count() as u64 + 5;
    for unit in 0..40 {
        let (with, without) = (fleet.unit(unit), whole.unit(unit));
        match unit {
            5 | 6 => {
                assert_eq!(with.missing, missing);
                assert_eq!(with.phase, Phase::Compensating);
                // Its bias is the same up to noise: r* is a thousandth, the residual a tenth.
                let mut r_star = [0.0; 2];
                fleet.compensated_into(unit, &mut r_star);
                assert!(
                    unit.is_multiple_of(3) || r_star.iter().all(|r| r.abs() < 0.01),
                    "{r_star:?}"
                );
                assert_eq!(with.decision.is_fault(), without.decision.is_fault());
            }
            7 => {
                assert_eq!((with.missing, with.samples), (700, 700));
                assert_eq!(with.phase, Phase::Training { samples: 0 });
                assert_eq!(with.verdict, None);
            }
            _ => assert_eq!(with, without),
        }
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let design = design(ArxOrders::paper(2));
    let refused = |design: &Design| Fleet::<f64, _, _>::new(design, 3).unwrap_err();
    let no_training = FleetDesign { training: 0, ..design.clone() };
    assert!(matches!(refused(&no_training), FleetError::Setting { setting: "training", .. }));
    let detector = Magnitude::new(&[1.0], 1.0).unwrap();
    let narrow = FleetDesign { detector, ..design.clone() };
    assert!(matches!(refused(&narrow), FleetError::Stage { expected: 2, found: 1, .. }));
    let learning = RlsDesign { prior_variance: -1.0, ..design.learning };
    let wrong = FleetDesign { learning, ..design.clone() };
    assert!(matches!(refused(&wrong), FleetError::Learning(_)));
    let mut fleet = Fleet::<f64, _, _>::new(&design, 3).unwrap();
    let error = fleet.update(&FleetBlock::new(IO, 4, 1)).unwrap_err();
    assert_eq!(error.to_string(), "a block of samples for 4 units was given to a fleet with 3");
    assert!(fleet.update(&FleetBlock::new(IoDims { nu: 2, ny: 2 }, 3, 1)).is_err());
    fleet.update(&FleetBlock::new(IO, 3, 0)).unwrap();
    assert_eq!(fleet.unit(2).samples, 0);
    let mut none = Fleet::<f64, _, _>::new(&design, 0).unwrap();
    none.update_on_all_cores(&FleetBlock::new(IO, 0, 5)).unwrap();
    assert!(none.is_empty());
}
