//! No stage of this crate allocates while it runs, in any phase.

use crate::support::{Arx2, Rls, paper_input, response, subject};
use allocation_counter::measure;
use fd_compensate::{
    DrivenRows, SampleRows,
    residual_compensation::{CompensationPlan, RangePolicy},
    testing::{every_compensator, every_detector, every_rule},
};
use fd_core::{
    EventKind, Frame, IoDims,
    stage::{BiasModel, Compensator, Evidence, Identifier, Phase},
};

#[test]
fn no_stage_allocates_per_sample() {
    let theta = [-1.3, 0.4, 0.05, -0.02, 0.01];
    let u: Vec<f64> = paper_input(4000)
        .iter()
        .enumerate()
        .map(|(k, v)| if k < 2000 { *v } else { v + 2.0 })
        .collect();
    let mut r = response::<2>(&theta, &u);
    // A hard fault in training, then one while compensating.
    r[400..480].iter_mut().for_each(|v| *v += 5.0);
    r[1800..1900].iter_mut().for_each(|v| *v += 5.0);

    let mut plan = CompensationPlan::default();
    plan.operating_point.policy = RangePolicy::Retrain;
    plan.convergence.least_samples = 450;
    let mut compensator = subject::<f64>(&plan);
    let (healthy_u, healthy) =
        (SampleRows::new(1, &u[..200]).unwrap(), SampleRows::new(1, &r[..200]).unwrap());
    let mut detectors =
        every_detector::<f64>(DrivenRows::new(healthy_u, healthy).unwrap()).unwrap();
    let mut rules = every_rule::<f64>(healthy).unwrap();

    let (mut frozen, mut trainings, mut hard) = (0, 0, 0);
    let (mut alarms, mut faults) = (vec![0; detectors.len()], vec![0; rules.len()]);
    let mut star = [0.0];
    let allocated = measure(|| {
        for (k, (u, r)) in (0..).zip(u.iter().zip(&r)) {
            let (u, y) = ([*u], [0.0]);
            let Ok(frame) = Frame::new(IoDims { nu: 1, ny: 1 }, k, &u, &y) else { continue };
            let outcome = compensator.step(frame, &[*r], &mut star);
            for kind in outcome.events.iter() {
                frozen += u32::from(kind == EventKind::Frozen);
                trainings += u32::from(kind == EventKind::TrainingStarted);
                hard += u32::from(kind == EventKind::HardFaultWhileTraining);
            }
            for ((_, detector), alarms) in detectors.iter_mut().zip(&mut alarms) {
                let verdict = detector.update(&u, &star);
                *alarms += u32::from(verdict.alarm());
                let phase = outcome.phase;
                let evidence = Evidence { k, phase, verdict, r_star: &star };
                for ((_, rule), faults) in rules.iter_mut().zip(&mut faults) {
                    *faults += u32::from(rule.decide(evidence).is_fault());
                }
            }
        }
    });
    // The run went through every phase, alarm and fault, so that the zero means something.
    assert!(frozen == 2 && trainings == 3 && hard == 1, "{frozen} {trainings} {hard}");
    assert!(alarms.iter().all(|n| *n > 0), "{alarms:?}");
    assert!(faults.iter().all(|n| *n > 0), "{faults:?}");
    assert_eq!(allocated.count_total, 0);
}

#[test]
fn the_counter_counts() {
    let allocated = measure(|| drop(std::hint::black_box(Box::new(0_u8))));
    assert_eq!(allocated.count_total, 1);
}

#[test]
fn no_compensator_allocates_per_sample() {
    let theta = [-1.3, 0.4, 0.05, -0.02, 0.01];
    let u = paper_input(1500);
    let r = response::<2>(&theta, &u);
    let mut learned = Rls::<f64, 2>::new();
    u.iter().zip(&r).for_each(|(u, r)| learned.update(&[*u], &[*r]));
    let mut model = Arx2::<f64>::new();
    model.load(learned.theta());
    for (name, mut compensator) in every_compensator(&learned, &model).unwrap() {
        let (mut compensated, mut star) = (0, [0.0]);
        compensator.reset();
        let allocated = measure(|| {
            for (k, (u, r)) in (0..).zip(u.iter().zip(&r)) {
                let (u, y) = ([*u], [0.0]);
                let Ok(frame) = Frame::new(IoDims { nu: 1, ny: 1 }, k, &u, &y) else { continue };
                let outcome = compensator.step(frame, &[*r], &mut star);
                compensated += u32::from(outcome.phase == Phase::Compensating);
            }
        });
        assert_eq!(allocated.count_total, 0, "{name}");
        assert!(compensated > 100, "{name}: {compensated}");
    }
}
