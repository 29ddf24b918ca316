//! The pipeline: stages that fit, samples that are missing, snapshots that are refused.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use fd_core::{
    BuildError, EventKind, Frame, FrameError, IoDims, MissingSamples, Pipeline, Snapshot,
    SnapshotError, Stages, StateVisitor,
    stage::{Detector, ResidualGenerator, Stage, Uncompensated, Verdict},
    testing::{memory, nonsense},
};

use crate::smallest::{AlarmIsFault, Lag};

/// Sum of `|r|`, so that the past matters.
#[derive(Clone, Debug)]
struct Sum {
    sum: f64,
    len: usize,
}

impl Stage for Sum {
    fn reset(&mut self) {
        self.sum = 0.0;
    }
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("sum", std::slice::from_mut(&mut self.sum));
    }
}

impl Detector for Sum {
    fn residual_len(&self) -> usize {
        self.len
    }
    fn update(&mut self, _u: &[f64], r: &[f64]) -> Verdict<f64> {
        self.sum = 0.9 * self.sum + r[0].abs();
        Verdict { statistic: self.sum, threshold: 1.0 }
    }
}

type TestPipeline = Pipeline<f64, Stages<Lag, Uncompensated, Sum, AlarmIsFault>>;

fn pipeline() -> TestPipeline {
    Pipeline::new(Stages {
        generator: Lag { previous: 0.0 },
        compensator: Uncompensated::new(1),
        detector: Sum { sum: 0.0, len: 1 },
        rule: AlarmIsFault,
    })
    .unwrap()
}

#[test]
fn stages_must_fit() {
    let misfit = Pipeline::new(Stages {
        generator: Lag { previous: 0.0 },
        compensator: Uncompensated::new(1),
        detector: Sum { sum: 0.0, len: 3 },
        rule: AlarmIsFault,
    });
    let expected = BuildError { stage: "detector", signal: "residual", expected: 3, found: 1 };
    assert_eq!(misfit.err(), Some(expected));
    assert_eq!(
        expected.to_string(),
        "detector expects 3 residual channels, the residual generator has 1"
    );
}

#[test]
fn a_rejected_sample_leaves_no_trace() {
    let (mut a, mut b) = (pipeline(), pipeline());
    for k in 0..20_u32 {
        let y = f64::from(k) * 0.01;
        assert_eq!(
            a.step(&[0.0], &[f64::NAN]).err(),
            Some(FrameError::NonFinite { k: u64::from(k), signal: "y", channel: 0 })
        );
        assert!(matches!(a.step(&[], &[y]).err(), Some(FrameError::Length { found: 0, .. })));
        let left = a.step(&[0.0], &[y]).unwrap().verdict;
        assert_eq!(left, b.step(&[0.0], &[y]).unwrap().verdict);
    }
}

#[test]
fn missing_samples_are_held_for_a_while() {
    let mut p = pipeline().with_missing_samples(MissingSamples::Hold { at_most: 2 });
    assert!(p.step(&[0.0], &[f64::NAN]).is_err(), "nothing to hold before the first sample");
    p.step(&[0.25], &[0.5]).unwrap();
    for _ in 0..2 {
        // y = 0.5 and u = 0.25 are held: r = 0.5 − 0.25 − 0.25 = 0, exact in binary.
        let step = p.step(&[f64::NAN], &[f64::INFINITY]).unwrap();
        assert_eq!(step.residual, [0.0]);
        assert_eq!(step.events.iter().collect::<Vec<_>>(), [EventKind::SampleHeld]);
    }
    assert!(p.step(&[f64::NAN], &[0.5]).is_err(), "a third one in a row is refused");
    p.step(&[0.25], &[0.5]).unwrap();
    assert!(p.step(&[f64::NAN], &[0.5]).is_ok(), "a good sample ends the row");
}

/// Remembers where in memory the samples were that it was shown.
#[derive(Clone, Debug, Default)]
struct Witness {
    seen: Vec<[usize; 2]>,
}

fn addresses(u: &[f64], y: &[f64]) -> [usize; 2] {
    [u.as_ptr().addr(), y.as_ptr().addr()]
}

impl Stage for Witness {
    fn reset(&mut self) {}
    fn visit_state(&mut self, _: &mut dyn StateVisitor<f64>) {}
}

impl ResidualGenerator for Witness {
    fn io(&self) -> IoDims {
        IoDims { nu: 1, ny: 1 }
    }
    fn residual_len(&self) -> usize {
        1
    }
    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        self.seen.push(addresses(frame.u(), frame.y()));
        r.fill(0.0);
    }
}

/// A good sample reaches the stages in the frame that it was checked in, on the caller's slices: there
/// is no copy that would have to be checked again. A held sample is another one, in memory of the
/// pipeline.
#[test]
fn the_frame_that_was_checked_is_the_one_that_is_used() {
    let mut p = Pipeline::new(Stages {
        generator: Witness::default(),
        compensator: Uncompensated::new(1),
        detector: Sum { sum: 0.0, len: 1 },
        rule: AlarmIsFault,
    })
    .unwrap()
    .with_missing_samples(MissingSamples::Hold { at_most: 1 });
    let (u, good, bad) = ([0.25], [0.5], [f64::NAN]);
    for y in [&good, &bad, &good] {
        p.step(&u, y).unwrap();
    }
    let seen = &p.stages().generator.seen;
    assert_eq!([seen[0], seen[2]], [addresses(&u, &good); 2]);
    assert!(seen[1] != addresses(&u, &bad) && seen[1] != addresses(&u, &good));
}

/// A NaN in `u` does not excuse a `y` of the wrong length.
#[test]
fn a_sample_of_the_wrong_size_is_never_held() {
    let mut p = pipeline().with_missing_samples(MissingSamples::Hold { at_most: 2 });
    p.step(&[0.25], &[0.5]).unwrap();
    for y in [&[][..], &[0.5, 0.5]] {
        let error = FrameError::Length { k: 1, signal: "y", expected: 1, found: y.len() };
        assert_eq!(p.step(&[f64::NAN], y).err(), Some(error));
    }
    let mut fresh = pipeline();
    fresh.step(&[0.25], &[0.5]).unwrap();
    assert_eq!(Snapshot::of(&mut p), Snapshot::of(&mut fresh), "nothing was held");
}

/// A snapshot is data from outside: what it left in the place of the last good sample is checked.
#[test]
fn a_held_sample_is_checked_too() {
    #[derive(Debug)]
    struct Spoil;
    impl StateVisitor<f64> for Spoil {
        fn reals(&mut self, name: &'static str, values: &mut [f64]) {
            if name == "pipeline y" {
                values.fill(f64::NAN);
            }
        }
        fn counts(&mut self, _: &'static str, _: &mut [u64]) {}
    }
    let mut p = pipeline().with_missing_samples(MissingSamples::Hold { at_most: 2 });
    p.step(&[0.25], &[0.5]).unwrap();
    p.visit_state(&mut Spoil);
    let error = FrameError::NonFinite { k: 1, signal: "y", channel: 0 };
    assert_eq!(p.step(&[0.25], &[f64::NAN]).err(), Some(error));
    assert!(p.step(&[0.25], &[0.5]).is_ok(), "the next good sample is taken");
}

#[test]
fn a_snapshot_of_something_else_is_refused() {
    let mut p = pipeline();
    p.step(&[0.0], &[0.3]).unwrap();
    let before = Snapshot::of(&mut p);
    let foreign = Snapshot::of(&mut Sum { sum: 2.0, len: 1 });
    let error = foreign.restore(&mut p).unwrap_err();
    assert!(matches!(error, SnapshotError::Field { index: 0, .. }), "{error}");
    assert!(matches!(
        before.restore(&mut Sum { sum: 2.0, len: 1 }),
        Err(SnapshotError::Field { .. })
    ));
    assert_eq!(Snapshot::of(&mut p), before, "a refused snapshot changes nothing");
}

/// A stage that forgets one of its two numbers where it is told to.
#[derive(Clone, Debug, Default)]
struct Forgetful {
    sums: [f64; 2],
    reset_forgets: bool,
    visit_forgets: bool,
}

impl Forgetful {
    fn step(&mut self, k: usize) -> f64 {
        self.sums[0] += k as f64;
        self.sums[1] += 1.0;
        self.sums[0] * self.sums[1]
    }
}

impl Stage for Forgetful {
    fn reset(&mut self) {
        let sums = if self.reset_forgets { &mut self.sums[..1] } else { &mut self.sums[..] };
        sums.fill(0.0);
    }
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("sum", &mut self.sums[..1]);
        if !self.visit_forgets {
            visitor.reals("other sum", &mut self.sums[1..]);
        }
    }
}

#[test]
fn a_stage_that_remembers_all_passes_the_law() {
    let whole = Forgetful::default();
    memory(&mut whole.clone(), &mut whole.clone(), 10, Forgetful::step);
    nonsense(&mut whole.clone(), 10, Forgetful::step);
}

#[test]
#[should_panic(expected = "reset must restart the stage")]
fn a_field_that_reset_forgets_breaks_the_law() {
    let broken = Forgetful { reset_forgets: true, ..Forgetful::default() };
    memory(&mut broken.clone(), &mut broken.clone(), 10, Forgetful::step);
}

#[test]
#[should_panic(expected = "a restored stage must continue")]
fn a_field_that_visit_state_forgets_breaks_the_law() {
    let broken = Forgetful { visit_forgets: true, ..Forgetful::default() };
    memory(&mut broken.clone(), &mut broken.clone(), 10, Forgetful::step);
}

#[test]
fn a_snapshot_of_which_one_number_was_altered_is_refused() {
    let mut original = pipeline();
    for k in 0..7_u8 {
        original.step(&[0.1], &[f64::from(k)]).unwrap();
    }
    let saved = serde_json::to_value(Snapshot::of(&mut original)).unwrap();
    let changed = crate::altered::with_one_number_altered(&saved);
    assert!(50 < changed.len(), "{}", changed.len());
    let mut restored = pipeline();
    let before = Snapshot::of(&mut restored);
    for value in changed {
        let Ok(snapshot) = serde_json::from_value::<Snapshot>(value.clone()) else { continue };
        let error = snapshot.restore(&mut restored).unwrap_err();
        assert!(
            matches!(error, SnapshotError::Damaged { .. } | SnapshotError::Version { .. }),
            "{value}: {error}"
        );
    }
    assert_eq!(Snapshot::of(&mut restored), before, "a refused snapshot changes nothing");
    serde_json::from_value::<Snapshot>(saved).unwrap().restore(&mut restored).unwrap();
    assert_ne!(Snapshot::of(&mut restored), before);
}

#[test]
fn a_refused_snapshot_says_what_was_expected_and_found() {
    let mut original = pipeline();
    let mut saved = serde_json::to_value(Snapshot::of(&mut original)).unwrap();
    saved["version"] = 9.into();
    let snapshot: Snapshot = serde_json::from_value(saved).unwrap();
    let error = snapshot.restore(&mut pipeline()).unwrap_err();
    assert_eq!(error.to_string(), "snapshot: expected version 1, found 9");

    let mut saved = serde_json::to_value(Snapshot::of(&mut original)).unwrap();
    saved["checksum"] = 10.into();
    let snapshot: Snapshot = serde_json::from_value(saved).unwrap();
    let text = snapshot.restore(&mut pipeline()).unwrap_err().to_string();
    assert!(text.contains("expected the checksum 000000000000000a"), "{text}");
}
