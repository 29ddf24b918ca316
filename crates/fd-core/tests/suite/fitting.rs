//! Pipelines whose stages fit or do not, and what a step hands on.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]
#![allow(clippy::float_cmp, reason = "small whole numbers are exact")]

use fd_core::{
    BuildError, EventKind, Events, Frame, FrameError, IoDims, MissingSamples, Pipeline, Snapshot,
    Stages, StateVisitor, Step,
    stage::{
        Compensation, Compensator, Decision, DecisionRule, Detector, Evidence, Fault, Phase,
        ResidualGenerator, Stage, Verdict,
    },
};

/// A stage whose numbers of channels are given, for pipelines that fit or do not.
#[derive(Clone, Debug)]
struct Sized {
    nu: usize,
    len: usize,
}

impl Stage for Sized {
    fn reset(&mut self) {}
    fn visit_state(&mut self, _visitor: &mut dyn StateVisitor<f64>) {}
}

impl ResidualGenerator for Sized {
    fn io(&self) -> IoDims {
        IoDims { nu: self.nu, ny: 1 }
    }
    fn residual_len(&self) -> usize {
        self.len
    }
    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        r.fill(frame.y()[0]);
    }
}

impl Compensator for Sized {
    fn nu(&self) -> Option<usize> {
        Some(self.nu)
    }
    fn residual_len(&self) -> usize {
        self.len
    }
    fn step(&mut self, _frame: Frame<'_, f64>, r: &[f64], r_star: &mut [f64]) -> Compensation {
        r_star.copy_from_slice(r);
        let mut events = Events::none();
        events.push(EventKind::WindUpGuard);
        Compensation { phase: Phase::Training { samples: 1 }, events }
    }
}

impl Detector for Sized {
    fn nu(&self) -> Option<usize> {
        Some(self.nu)
    }
    fn residual_len(&self) -> usize {
        self.len
    }
    fn update(&mut self, _u: &[f64], r: &[f64]) -> Verdict<f64> {
        Verdict { statistic: r[0], threshold: 1.0 }
    }
}

impl DecisionRule for Sized {
    fn residual_len(&self) -> usize {
        self.len
    }
    fn decide(&mut self, evidence: Evidence<'_, f64>) -> Decision<f64> {
        let Evidence { k, verdict, .. } = evidence;
        if verdict.alarm() { Decision::Fault(Fault::since(k)) } else { Decision::Nominal }
    }
}

type SizedPipeline = Pipeline<f64, Stages<Sized, Sized, Sized, Sized>>;

/// Stages by `[inputs, residuals]`: of the generator, compensator, detector and rule.
fn joined(sizes: [[usize; 2]; 4]) -> Result<SizedPipeline, BuildError> {
    let [generator, compensator, detector, rule] = sizes.map(|[nu, len]| Sized { nu, len });
    Pipeline::new(Stages { generator, compensator, detector, rule })
}

#[test]
fn each_stage_that_does_not_fit_is_named() {
    let fits = [[2, 3], [2, 3], [2, 3], [0, 3]];
    assert!(joined(fits).is_ok());
    for (stage, name) in [(1, "compensator"), (2, "detector"), (3, "decision rule")] {
        let mut other = fits;
        other[stage][1] = 4;
        let (expected, found) = (4, 3);
        let error = BuildError { stage: name, signal: "residual", expected, found };
        assert_eq!(joined(other).unwrap_err(), error);
        // A decision rule sees no input.
        if stage < 3 {
            let mut other = fits;
            other[stage][0] = 5;
            let (expected, found) = (5, 2);
            let error = BuildError { stage: name, signal: "input", expected, found };
            assert_eq!(joined(other).unwrap_err(), error);
        }
    }
}

/// Runs of samples end at the first bad one; a step carries the phase and events of its
/// compensator, the alarm after them.
#[test]
fn a_run_hands_on_every_step_until_a_bad_sample() {
    let mut pipeline = joined([[1, 1]; 4]).unwrap();
    assert_eq!(pipeline.stages().generator.len, 1);
    let samples: Vec<[f64; 1]> = [0.0, 2.0, 3.0, 0.0, f64::NAN, 9.0].map(|y| [y]).into();
    let mut seen = Vec::new();
    let mut sink = |step: Step<'_, f64>| {
        assert_eq!(step.phase, Phase::Training { samples: 1 });
        assert_eq!(step.residual, step.compensated);
        seen.push((step.k, step.residual[0], step.events.iter().collect::<Vec<_>>()));
    };
    let error = pipeline.run(samples.iter().map(|y| (&[0.0][..], &y[..])), &mut sink).unwrap_err();
    assert_eq!(error, FrameError::NonFinite { k: 4, signal: "y", channel: 0 });
    let guard = EventKind::WindUpGuard;
    let expected = [
        (0, 0.0, vec![guard]),
        (1, 2.0, vec![guard, EventKind::AlarmRaised]),
        (2, 3.0, vec![guard]),
        (3, 0.0, vec![guard, EventKind::AlarmCleared]),
    ];
    assert_eq!(seen, expected);
}

/// Channel by channel: what is finite counts, what is not is held.
#[test]
fn only_the_missing_channels_are_held() {
    let mut pipeline =
        joined([[1, 1]; 4]).unwrap().with_missing_samples(MissingSamples::Hold { at_most: 1 });
    assert!(pipeline.step(&[1.0], &[5.0]).unwrap().decision.is_fault());
    let step = pipeline.step(&[f64::NAN], &[6.0]).unwrap();
    assert_eq!((step.k, step.residual), (1, &[6.0][..]));
    let wrong = pipeline.step(&[0.0, 0.0], &[6.0]).unwrap_err();
    let length = FrameError::Length { k: 2, signal: "u", expected: 1, found: 2 };
    assert_eq!(wrong, length, "a wrong channel is not a missing one");
    // Alarm, index and the row of held samples are part of the memory, and of what a reset clears.
    let snapshot = Snapshot::of(&mut pipeline);
    let mut restored =
        joined([[1, 1]; 4]).unwrap().with_missing_samples(MissingSamples::Hold { at_most: 1 });
    snapshot.restore(&mut restored).unwrap();
    assert!(restored.step(&[f64::NAN], &[0.0]).is_err(), "one sample is held already");
    let cleared: Vec<EventKind> = restored.step(&[0.0], &[0.0]).unwrap().events.iter().collect();
    assert_eq!(cleared, [EventKind::WindUpGuard, EventKind::AlarmCleared]);
    pipeline.reset();
    assert_eq!(pipeline.step(&[0.0], &[0.0]).unwrap().k, 0);
}
