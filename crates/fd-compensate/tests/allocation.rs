//! No stage of this crate allocates while it runs, in any phase.
#![allow(unsafe_code, reason = "a counting allocator cannot be written without")]

mod support;

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use fd_compensate::{
    SampleRows,
    decide::{
        Candidate, Debouncing, FaultFree, Hypothesis, IsolatingDebounce, Isolation, SizedDebounce,
        Sizing,
    },
    detect::{
        AdaptiveThreshold, ChiSquare, Cusum, Glr, Magnitude, NSigma, Sprt, Standardizer, TwoSample,
        adaptive::{Bands, InputBound},
        glr::{Course, GlrDesign},
        sprt::{ErrorProbabilities, Sides},
        two_sample::SampleTest,
        whiten::WhitenerDesign,
    },
    residual_compensation::{CompensationPlan, RangePolicy},
};
use fd_core::{
    EventKind, Frame, IoDims,
    stage::{Compensator, Decision, DecisionRule, Detector, Evidence, Phase},
};
use support::{paper_input, response, subject};

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is handed to the system allocator unchanged; counting does not allocate, since
// the thread-local is a constant-initialised cell without a destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

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
    let unit = || Standardizer::new(&[0.0], &[1.0]).unwrap();
    let errors = ErrorProbabilities { false_alarm: 0.01, missed: 0.05 };
    let healthy = SampleRows::new(1, &r[..200]).unwrap();
    let whitener = WhitenerDesign::from_fault_free(healthy, 3).unwrap();
    let glr = GlrDesign::any_direction(whitener, &[Course::Step], 9).unwrap();
    let bound = InputBound::new(Bands::new(&[0.1], 9.0).unwrap(), 1, &[0.1], &[0.1, 0.1]).unwrap();
    let mut detectors: Vec<Box<dyn Detector<f64>>> = vec![
        Box::new(Magnitude::new(&[1.0], 0.1).unwrap()),
        Box::new(NSigma::new(unit(), 3.0).unwrap()),
        Box::new(ChiSquare::new(&[0.0], &[1.0], 20, 10.0).unwrap()),
        Box::new(Cusum::new(unit(), 0.5, 4.0).unwrap()),
        Box::new(Sprt::new(unit(), 1.0, errors, Sides::Both).unwrap()),
        Box::new(Glr::new(&glr, 10.0).unwrap()),
        Box::new(TwoSample::new(SampleTest::Distribution, healthy, 9, 1.6).unwrap()),
        Box::new(TwoSample::new(SampleTest::Variance, healthy, 9, 1.6).unwrap()),
        Box::new(AdaptiveThreshold::of_rms(&bound, 2.0).unwrap()),
    ];
    let hypotheses = [Hypothesis { name: "T7".into(), signature: vec![1.0] }];
    let mut rule =
        SizedDebounce::new(1, Debouncing::consecutive(5), &hypotheses, &Sizing::default()).unwrap();

    let noise = FaultFree::new(&[0.0], &[1.0], 2.0).unwrap();
    let candidates = hypotheses.map(Candidate::from);
    let consecutive = Debouncing::consecutive(5);
    let mut isolating =
        IsolatingDebounce::new(&noise, &candidates, consecutive, &Isolation::default()).unwrap();

    let (mut faults, mut frozen, mut trainings, mut hard) = (0, 0, 0, 0);
    let mut star = [0.0];
    let before = ALLOCATIONS.get();
    for (k, (u, r)) in (0..).zip(u.iter().zip(&r)) {
        let (u, y) = ([*u], [0.0]);
        let Ok(frame) = Frame::new(IoDims { nu: 1, ny: 1 }, k, &u, &y) else { continue };
        let outcome = compensator.step(frame, &[*r], &mut star);
        for kind in outcome.events.iter() {
            frozen += u32::from(kind == EventKind::Frozen);
            trainings += u32::from(kind == EventKind::TrainingStarted);
            hard += u32::from(kind == EventKind::HardFaultWhileTraining);
        }
        for detector in &mut detectors {
            let verdict = detector.update(&u, &star);
            let phase = outcome.phase;
            let evidence = Evidence { k, phase, verdict, r_star: &star };
            let both = [rule.decide(evidence), isolating.decide(evidence)];
            let is_on = phase == Phase::Compensating;
            faults += u32::from(is_on && both.iter().all(Decision::is_fault));
        }
    }
    let allocations = ALLOCATIONS.get() - before;
    // The run went through every phase, so that the zero means something.
    assert!(
        frozen == 2 && trainings == 3 && hard == 1 && faults > 0,
        "{frozen} {trainings} {hard}"
    );
    assert_eq!(allocations, 0);
    // The counter counts.
    let _kept = Box::new(0_u8);
    assert!(ALLOCATIONS.get() > before);
}
