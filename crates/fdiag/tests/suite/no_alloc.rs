//! No pipeline allocates per sample: neither with static nor with boxed stages, in any phase.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::support::{calibration, eventful, nominal, spec, training, ts};
use allocation_counter::measure;
use faer::mat;
use fdiag::{
    compensate::{
        decide::{Debounce, Debouncing},
        detect::Magnitude,
        residual_compensation::{CompensationPlan, RangePolicy, ResidualCompensator},
    },
    core::{
        EventKind, Fixed, MissingSamples, Pipeline, Stages, Storage,
        stage::{Compensator, DecisionRule, Detector, Phase, ResidualGenerator},
    },
    fleet::{Fleet, FleetBlock, FleetDesign},
    ident::{
        arx::{ArxOrders, ArxSimulator, RecursiveArx},
        rls::{RlsDesign, Static, UdRls},
    },
    model::{Record, freeze},
    residual::{observer::ObserverDesign, weighted::Weighted},
    training::{Healthy, train},
};

/// What a run went through, and what it cost.
#[derive(Debug, Default)]
struct Tally {
    training: u64,
    compensating: u64,
    frozen: u64,
    alarms: u64,
    held: u64,
    refused: u64,
    allocations: u64,
}

fn tally<G, C, D, J>(pipeline: &mut Pipeline<f64, Stages<G, C, D, J>>, record: &Record) -> Tally
where
    G: ResidualGenerator,
    C: Compensator,
    D: Detector,
    J: DecisionRule,
{
    let mut tally = Tally::default();
    let allocated = measure(|| {
        for (u, y) in record.samples() {
            let Ok(step) = pipeline.step(u, y) else {
                tally.refused += 1;
                continue;
            };
            match step.phase {
                Phase::Training { .. } => tally.training += 1,
                Phase::Compensating => tally.compensating += 1,
            }
            for kind in step.events.iter() {
                tally.frozen += u64::from(kind == EventKind::Frozen);
                tally.alarms += u64::from(kind == EventKind::AlarmRaised);
                tally.held += u64::from(kind == EventKind::SampleHeld);
            }
        }
    });
    tally.allocations = allocated.count_total;
    tally
}

/// A run through all phases with a short and a long gap.
fn with_gaps() -> Record {
    let mut record = eventful();
    record.y_mut(300).fill(f64::NAN);
    (400..410).for_each(|k| record.y_mut(k)[0] = f64::NAN);
    record
}

/// The zero means something only if the run went through everything.
fn assert_free(tally: &Tally) {
    assert!(tally.training > 200 && tally.compensating > 200, "{tally:?}");
    assert!(tally.frozen >= 1 && tally.alarms >= 1, "{tally:?}");
    assert!(tally.held == 4 && tally.refused == 7, "{tally:?}");
    assert_eq!(tally.allocations, 0);
}

const GAPS: MissingSamples = MissingSamples::Hold { at_most: 3 };

#[test]
fn a_static_pipeline_does_not_allocate() {
    type Size = Fixed<2, 1, 2>;
    type Row = <Fixed<2, 1, 1> as Storage<f64>>::Yx;
    let design = ObserverDesign::faster(&nominal(), 2.0).unwrap();
    let weight: Row = freeze("W", mat![[1.0, 0.5]].as_ref()).unwrap();
    let observer = design.freeze::<f64, Size>().unwrap();
    let generator: Weighted<f64, _, Row, [f64; 2]> = Weighted::new(observer, weight).unwrap();
    let orders = ArxOrders::paper(2);
    let kernel =
        UdRls::<f64, Static<5, 1>>::new(orders.parameters(1), &RlsDesign::default()).unwrap();
    let identifier = RecursiveArx::new(orders, 1, 1, kernel).unwrap();
    let mut plan = CompensationPlan::default();
    plan.operating_point.policy = RangePolicy::Retrain;
    let simulator = ArxSimulator::new(orders, 1, 1).unwrap();
    let mut pipeline = Pipeline::new(Stages {
        generator,
        compensator: ResidualCompensator::new(identifier, simulator, &plan).unwrap(),
        detector: Magnitude::new(&[1.0], 0.01).unwrap(),
        rule: Debounce::new(1, Debouncing::consecutive(3)).unwrap(),
    })
    .unwrap()
    .with_missing_samples(GAPS);
    assert_free(&tally(&mut pipeline, &with_gaps()));
}

#[test]
fn a_boxed_pipeline_from_a_spec_does_not_allocate() {
    let (training, calibration) = (training(), calibration());
    let healthy = [Healthy::learn(&training), Healthy::calibrate(&calibration)];
    let mut spec = spec();
    spec.hold_missing = 3;
    let trained = train(&spec, &nominal(), &healthy).unwrap();
    assert_free(&tally(&mut trained.compensated().unwrap(), &with_gaps()));
}

/// Training and compensation of two parts, one of them not full, in blocks of several lengths.
#[test]
fn a_fleet_does_not_allocate() {
    let observer = ObserverDesign::faster(&nominal(), 2.0).unwrap();
    let design = FleetDesign {
        generator: observer.form().unwrap(),
        orders: ArxOrders::paper(2),
        learning: RlsDesign::default(),
        settling: 10,
        training: 100,
        detector: Magnitude::new(&[1.0, 1.0], 0.01).unwrap(),
        rule: Debounce::new(2, Debouncing::consecutive(3)).unwrap(),
    };
    let units = 200;
    let mut fleet = Fleet::<f64, _, _>::new(&design, units).unwrap();
    let record = training();
    let io = fdiag::core::IoDims { nu: 1, ny: 2 };
    let mut first = 0;
    for steps in [1, 60, 7, 90] {
        let mut block = FleetBlock::new(io, units, steps);
        for (unit, step) in (0..units).flat_map(|unit| (0..steps).map(move |step| (unit, step))) {
            let k = first + step;
            block.set(unit, step, record.u(k), record.y(k));
        }
        let allocated = measure(|| fleet.update(&block).unwrap());
        assert_eq!(allocated.count_total, 0, "{steps} samples from {first} on");
        first += steps;
    }
    assert_eq!(fleet.unit(199).phase, Phase::Compensating);
}

/// The counter counts.
#[test]
fn an_allocation_is_seen() {
    let allocated = measure(|| drop(std::hint::black_box(Box::new(ts()))));
    assert_eq!(allocated.count_total, 1);
}
