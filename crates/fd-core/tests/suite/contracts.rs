//! The small parts of the contracts: maps, buffers, scalars, frames, reports, events, snapshots.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]
#![allow(clippy::float_cmp, reason = "small whole numbers are exact")]

use fd_core::{
    Buffer, EventKind, Events, Fixed, Frame, FrameError, Heap, HeapMap, IoDims, LinMap, Scalar,
    Shape, ShapeError, Snapshot, SnapshotError, StateVisitor, Storage,
    stage::{Compensator, GuardReport, Phase, Stage, Uncompensated, Verdict},
    testing::memory,
};

/// `A = [1 2 3; 4 5 6]`, exact in any precision.
fn counted<M: LinMap<f64>>() -> M {
    M::from_fn("A", Shape::new(2, 3), |i, j| (3 * i + j + 1) as f64).unwrap()
}

#[test]
fn maps_multiply_and_add() {
    fn check<M: LinMap<f64>>() {
        let map: M = counted();
        assert_eq!(map.dims(), Shape::new(2, 3));
        let mut y = [100.0, 200.0];
        map.mul_into(&[1.0, -1.0, 2.0], &mut y);
        assert_eq!(y, [5.0, 11.0], "what was in y does not matter");
        map.mul_add_into(&[0.0, 1.0, 0.0], &mut y);
        assert_eq!(y, [7.0, 16.0]);
    }
    check::<<Fixed<2, 3, 2> as Storage<f64>>::Xu>();
    check::<HeapMap<f64>>();
}

#[test]
fn fixed_storage_refuses_other_sizes() {
    type Storage3 = Fixed<3, 1, 2>;
    fn refused<M: LinMap<f64>>(shape: Shape) -> ShapeError {
        M::from_fn("C", shape, |_, _| 0.0).unwrap_err()
    }
    let wrong = refused::<<Storage3 as Storage<f64>>::Yx>(Shape::new(3, 2));
    let (expected, found) = (Shape::new(2, 3), Shape::new(3, 2));
    assert_eq!(wrong, ShapeError { role: "C", expected, found });
    let wrong = <Storage3 as Storage<f64>>::X::zeros("x", 2).unwrap_err();
    let (expected, found) = (Shape::new(3, 1), Shape::new(2, 1));
    assert_eq!(wrong, ShapeError { role: "x", expected, found });
    assert_eq!(wrong.to_string(), "x must be 3x1, got 2x1");
    assert_eq!(<Storage3 as Storage<f64>>::X::zeros("x", 3).unwrap(), [0.0; 3]);
    assert_eq!(<Heap as Storage<f64>>::X::zeros("x", 2).unwrap(), [0.0; 2]);
}

#[test]
fn scalars_round_and_widen() {
    assert_eq!(f32::from_design(0.1).to_bits(), 0.1_f32.to_bits());
    assert_eq!(0.1_f32.to_report().to_bits(), f64::from(0.1_f32).to_bits());
    assert_eq!((-2.5_f64).to_report().to_bits(), (-2.5_f64).to_bits());
}

#[test]
fn a_frame_gives_back_its_sample_and_names_what_is_wrong() {
    let io = IoDims { nu: 1, ny: 2 };
    let frame = Frame::new(io, 7, &[1.0], &[2.0, 3.0]).unwrap();
    assert_eq!((frame.k(), frame.u(), frame.y()), (7, &[1.0][..], &[2.0, 3.0][..]));
    let error = |u: &[f64], y: &[f64]| Frame::new(io, 7, u, y).map(|_| ()).unwrap_err();
    let (k, signal) = (7, "u");
    assert_eq!(error(&[], &[2.0, 3.0]), FrameError::Length { k, signal, expected: 1, found: 0 });
    let not_finite = FrameError::NonFinite { k, signal, channel: 0 };
    assert_eq!(error(&[f64::INFINITY], &[2.0, 3.0]), not_finite);
    let signal = "y";
    assert_eq!(error(&[1.0], &[2.0]), FrameError::Length { k, signal, expected: 2, found: 1 });
    assert_eq!(error(&[1.0], &[2.0, f64::NAN]), FrameError::NonFinite { k, signal, channel: 1 });
}

#[test]
fn guard_reports_add_up() {
    let report = |skipped, bounded| GuardReport { skipped, bounded };
    assert!(!report(0, 0).acted());
    assert!(report(1, 0).acted() && report(0, 1).acted() && report(3, 3).acted());
    let sum: GuardReport = [report(1, 2), report(3, 5), report(0, 1)].into_iter().sum();
    assert_eq!(sum, report(4, 8));
    assert_eq!(std::iter::empty::<GuardReport>().sum::<GuardReport>(), report(0, 0));
}

#[test]
fn more_events_than_fit_lose_the_last_but_one() {
    let all = [
        EventKind::TrainingStarted,
        EventKind::Frozen,
        EventKind::TrainingInconclusive,
        EventKind::BiasModelRejected,
        EventKind::HardFaultWhileTraining,
        EventKind::OperatingPointLeft,
        EventKind::OperatingPointRegained,
        EventKind::WindUpGuard,
    ];
    let mut events = Events::none();
    for (n, &kind) in (1..).zip(&all) {
        events.push(kind);
        let kept: Vec<EventKind> = events.iter().collect();
        let capacity = Events::CAPACITY;
        if n <= capacity {
            assert_eq!(kept, all[..n]);
        } else {
            assert_eq!((&kept[..capacity - 1], kept[capacity - 1]), (&all[..capacity - 1], kind));
        }
    }
}

#[test]
fn every_event_has_words_of_its_own() {
    let words = |kind: EventKind| kind.to_string();
    for (kind, expected) in [
        (EventKind::TrainingStarted, "training started"),
        (EventKind::Frozen, "parameters converged and frozen"),
        (EventKind::AlarmRaised, "alarm raised"),
        (EventKind::SampleHeld, "missing sample held"),
    ] {
        assert_eq!(words(kind), expected);
    }
}

#[test]
fn a_statistic_at_its_threshold_is_no_alarm() {
    let alarm = |statistic, threshold| Verdict { statistic, threshold }.alarm();
    assert!(alarm(1.5, 1.0) && !alarm(1.0, 1.0) && !alarm(0.5, 1.0));
    assert!(!alarm(f64::NAN, 1.0));
}

#[test]
fn without_compensation_the_residual_passes() {
    let mut none = Uncompensated::new(2);
    let sizes = (Compensator::<f64>::nu(&none), Compensator::<f64>::residual_len(&none));
    assert_eq!(sizes, (None, 2));
    let frame = Frame::new(IoDims { nu: 0, ny: 0 }, 0, &[], &[]).unwrap();
    let mut r_star = [0.0; 2];
    let done = none.step(frame, &[1.0, -2.0], &mut r_star);
    assert_eq!((done.phase, r_star), (Phase::Compensating, [1.0, -2.0]));
    assert_eq!(done.events, Events::none());

    let settles = || Uncompensated::new(2).settling(3);
    memory::<f64, _, _>(&mut settles(), &mut settles(), 8, |stage, _| {
        stage.step(frame, &[1.0, -2.0], &mut r_star)
    });
}

#[test]
fn snapshots_of_other_sizes_are_refused_by_name() {
    struct Reals<const N: usize>([f64; N]);
    impl<const N: usize> std::fmt::Debug for Reals<N> {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            self.0.fmt(f)
        }
    }
    impl<const N: usize> Stage for Reals<N> {
        fn reset(&mut self) {
            self.0 = [0.0; N];
        }
        fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
            visitor.reals("x", &mut self.0);
            if 2 < N {
                visitor.reals("more", &mut []);
            }
        }
    }
    let saved = Snapshot::of(&mut Reals([1.0, f64::NEG_INFINITY]));
    let mut back = Reals([0.0; 2]);
    saved.restore(&mut back).unwrap();
    assert_eq!(back.0, [1.0, f64::NEG_INFINITY]);
    let error = saved.restore(&mut Reals([0.0; 1])).unwrap_err();
    let words = "snapshot field 0: expected `x` with 1 values, found `x` with 2 values";
    assert_eq!(error.to_string(), words);
    let three = Snapshot::of(&mut Reals([0.0; 3]));
    assert!(matches!(
        three.restore(&mut Reals([0.0; 2])),
        Err(SnapshotError::Field { index: 0, .. })
    ));
    for nan in [f64::NAN, -f64::NAN] {
        let error = Snapshot::of(&mut Reals([0.5, nan])).restore(&mut back).unwrap_err();
        assert_eq!(error.to_string(), "snapshot field `x`, value 2: expected a number, found NaN");
        assert_eq!(back.0, [1.0, f64::NEG_INFINITY], "a refused snapshot changes nothing");
    }
    let mut nothing = Uncompensated::new(2);
    let surplus = saved.restore::<f64>(&mut nothing).unwrap_err();
    assert_eq!(surplus, SnapshotError::Surplus { expected: 0, found: 1 });
}

/// A count beyond 2^53 is none that any run has left, and sums with it would overflow.
#[test]
fn snapshots_of_endless_counts_are_refused() {
    #[derive(Debug)]
    struct Count(u64);
    impl Stage for Count {
        fn reset(&mut self) {
            self.0 = 0;
        }
        fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
            visitor.counts("n", std::slice::from_mut(&mut self.0));
        }
    }
    let most = 1 << 53;
    let mut back = Count(0);
    assert_eq!(Snapshot::of(&mut Count(most)).restore(&mut back), Ok(()));
    let error = Snapshot::of(&mut Count(most + 1)).restore(&mut back).unwrap_err();
    let words =
        "snapshot field `n`, value 1: expected a count of at most 2^53, found 9007199254740993";
    assert_eq!((error.to_string().as_str(), back.0), (words, most));
}
