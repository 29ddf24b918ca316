//! The stages of this crate in a pipeline: what the detector sees is what the compensator leaves.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use fd_compensate::{
    DrivenRows, SampleRows,
    decide::{Debounce, Debouncing},
    detect::Magnitude,
    residual_compensation::CompensationPlan,
    testing::every_detector,
};
use fd_core::{
    EventKind, Frame, IoDims, Pipeline, Snapshot, Stages, StateVisitor,
    stage::{Decision, Detector, Phase, ResidualGenerator, Stage, Uncompensated},
};

use crate::support::{Subject, paper_input, response, subject};

/// The output is the residual, but for inputs beyond ten, where there is no answer.
#[derive(Clone, Debug)]
struct Passes;

impl Stage for Passes {
    fn reset(&mut self) {}
    fn visit_state(&mut self, _: &mut dyn StateVisitor<f64>) {}
}

impl ResidualGenerator for Passes {
    fn io(&self) -> IoDims {
        IoDims { nu: 1, ny: 1 }
    }
    fn residual_len(&self) -> usize {
        1
    }
    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        r[0] = if frame.u()[0] > 10.0 { f64::NAN } else { frame.y()[0] };
    }
}

/// A bias five times as large as the threshold raises no alarm, neither while it is learned nor once it is taken
/// away; a fault of a fifth of it does, at its first sample, and is gone with its last.
#[test]
fn the_bias_is_no_alarm_and_a_fault_a_fifth_as_large_is() {
    let u = paper_input(1600);
    let mut y = response::<2>(&[-1.3, 0.4, 0.05, -0.02, 0.01], &u);
    let threshold = 0.2 * y[1000..].iter().fold(f64::INFINITY, |least, v| least.min(v.abs()));
    let fault = 1000..1300;
    y[fault.clone()].iter_mut().for_each(|y| *y += 1.01 * threshold);
    let compensator: Subject = subject(&CompensationPlan::default());
    let mut pipeline = Pipeline::new(Stages {
        generator: Passes,
        compensator,
        detector: Magnitude::new(&[1.0], threshold).unwrap(),
        rule: Debounce::new(1, Debouncing::consecutive(3)).unwrap(),
    })
    .unwrap();
    let (mut alarms, mut trained) = (Vec::new(), 0);
    for (u, y) in u.iter().zip(&y) {
        let step = pipeline.step(&[*u], &[*y]).unwrap();
        trained += usize::from(step.phase != Phase::Compensating);
        for kind in step.events.iter() {
            if kind == EventKind::AlarmRaised {
                let Decision::Fault(found) = step.decision else { unreachable!() };
                alarms.push((kind, found.since, step.k));
            } else if kind == EventKind::AlarmCleared {
                alarms.push((kind, step.k - 2, step.k));
            }
        }
    }
    assert!((200..600).contains(&trained), "{trained}");
    let [from, to] = [fault.start, fault.end].map(|k| k as u64);
    let raised = (EventKind::AlarmRaised, from, from + 2);
    assert_eq!(alarms, [raised, (EventKind::AlarmCleared, to, to + 2)]);
}

/// Nothing is left of a sample without a residual, in any detector: what was saved after it is restored, and what
/// follows is judged as if it were the beginning.
#[test]
fn a_sample_without_a_residual_leaves_nothing_in_any_detector() {
    let u = paper_input(300);
    let r: Vec<f64> = (0..300).map(|k| (f64::from(k).powi(2) * 0.618).sin()).collect();
    let rows = |values| SampleRows::new(1, values).unwrap();
    let every = || every_detector::<f64>(DrivenRows::new(rows(&u), rows(&r)).unwrap()).unwrap();
    for ((name, mut fresh), ((_, one), (_, other))) in
        every().into_iter().zip(every().into_iter().zip(every()))
    {
        let new = |detector| {
            let rule = Debounce::new(1, Debouncing::default()).unwrap();
            let compensator = Uncompensated::new(1);
            Pipeline::new(Stages { generator: Passes, compensator, detector, rule }).unwrap()
        };
        let (mut pipeline, mut restored) = (new(one), new(other));
        for k in 0..100 {
            pipeline.step(&u[k..=k], &r[k..=k]).unwrap();
        }
        assert!(pipeline.step(&[11.0], &[0.0]).unwrap().residual[0].is_nan());
        let saved = Snapshot::of(&mut pipeline).restore(&mut restored);
        assert!(saved.is_ok(), "{name}: {saved:?}");
        for k in 100..300 {
            let expected = fresh.update(&u[k..=k], &r[k..=k]);
            assert_eq!(pipeline.step(&u[k..=k], &r[k..=k]).unwrap().verdict, expected, "{name}");
            assert_eq!(restored.step(&u[k..=k], &r[k..=k]).unwrap().verdict, expected, "{name}");
        }
    }
}
