//! Debounced alarms, estimated sizes, and what the offline evaluation says of them.
#![allow(clippy::panic, clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use fd_compensate::{
    SampleRows,
    decide::{Debounce, Debouncing, Hypothesis, RuleError, SizedDebounce, Sizing},
    detect::{Cusum, Magnitude, Standardizer},
    evaluate::{
        alarms, debounced_statistics, detection_delay, smallest_detectable,
        smallest_detectable_by_search,
    },
};
use fd_core::{
    Snapshot,
    stage::{Decision, DecisionRule, Detector, Evidence, Fault, Phase, Stage, Verdict},
};
use proptest::prelude::*;

const TRAINING: Phase = Phase::Training { samples: 0 };

fn at(k: u64, phase: Phase, statistic: f64, r_star: &[f64]) -> Evidence<'_, f64> {
    Evidence { k, phase, verdict: Verdict { statistic, threshold: 1.0 }, r_star }
}

/// Judges a sequence of alarming (`true`) samples.
fn judge(rule: &mut impl DecisionRule<f64>, alarming: &[bool]) -> Vec<Option<u64>> {
    (0..)
        .zip(alarming)
        .map(|(k, &alarm)| {
            let statistic = if alarm { 2.0 } else { 0.0 };
            match rule.decide(at(k, Phase::Compensating, statistic, &[statistic])) {
                Decision::Fault(fault) => Some(fault.since),
                _ => None,
            }
        })
        .collect()
}

#[test]
fn two_of_three_raise_and_two_normal_clear() {
    let debouncing = Debouncing { raise: 2, out_of: 3, clear: 2, latch: false };
    let mut rule = Debounce::new(1, debouncing).unwrap();
    let (o, x) = (false, true);
    let judged = judge(&mut rule, &[x, o, o, x, o, x, o, x, o, o, x, o]);
    let since = Some(3);
    assert_eq!(
        judged,
        [None, None, None, None, None, since, since, since, since, None, None, None]
    );
}

#[test]
fn a_latched_alarm_stays_until_reset() {
    let debouncing = Debouncing { latch: true, ..Debouncing::default() };
    let mut rule = Debounce::new(1, debouncing).unwrap();
    assert_eq!(judge(&mut rule, &[false, true, false, false]), [None, Some(1), Some(1), Some(1)]);
    assert!(rule.decide(at(4, TRAINING, 0.0, &[0.0])).is_fault());
    Stage::<f64>::reset(&mut rule);
    assert_eq!(judge(&mut rule, &[false]), [None]);
}

#[test]
fn training_is_mute_and_forgets() {
    let mut rule = Debounce::new(1, Debouncing::consecutive(2)).unwrap();
    assert!(!rule.decide(at(0, Phase::Compensating, 2.0, &[2.0])).is_fault());
    assert!(!rule.decide(at(1, TRAINING, 2.0, &[2.0])).is_fault());
    assert!(!rule.decide(at(2, Phase::Compensating, 2.0, &[2.0])).is_fault());
    let decision = rule.decide(at(3, Phase::Compensating, 2.0, &[2.0]));
    assert_eq!(decision, Decision::Fault(Fault::since(2)));
    assert!(!rule.decide(at(4, TRAINING, 2.0, &[2.0])).is_fault());
}

#[test]
fn malformed_counts_are_refused() {
    for (raise, out_of, clear, parameter) in
        [(0, 1, 1, "raise"), (3, 2, 1, "out_of"), (1, 1, 0, "clear")]
    {
        let debouncing = Debouncing { raise, out_of, clear, latch: false };
        let error = Debounce::new(1, debouncing).unwrap_err();
        assert!(matches!(error, RuleError::Count { parameter: p, .. } if p == parameter));
    }
}

fn hypotheses(signatures: &[&[f64]]) -> Vec<Hypothesis> {
    let named = signatures.iter().enumerate();
    named.map(|(i, s)| Hypothesis { name: format!("f{i}"), signature: s.to_vec() }).collect()
}

fn last_fault(rule: &mut SizedDebounce<f64>, rows: &[[f64; 2]]) -> Fault<f64> {
    let mut last = Decision::Nominal;
    for (k, r) in (0..).zip(rows) {
        last = rule.decide(at(k, Phase::Compensating, 2.0, r));
    }
    match last {
        Decision::Fault(fault) => fault,
        _ => panic!("no fault raised"),
    }
}

#[test]
fn the_hypothesis_of_the_right_direction_is_named_with_its_size() {
    let set = hypotheses(&[&[1.0, 0.5], &[-0.2, 2.0], &[1.0, 1.0]]);
    let debouncing = Debouncing::consecutive(3);
    for (index, size) in [(0, 0.7), (1, -0.3), (2, 2.0)] {
        let g = &set[index].signature;
        // Alternating noise with zero mean over an even number of samples.
        let rows: Vec<[f64; 2]> = (0..200)
            .map(|k| {
                let e = if k % 2 == 0 { 0.1 } else { -0.1 };
                [g[0] * size + e, g[1] * size - e]
            })
            .collect();
        let mut rule = SizedDebounce::new(2, debouncing, &set, &Sizing::default()).unwrap();
        let fault = last_fault(&mut rule, &rows);
        assert_eq!((fault.since, fault.hypothesis), (0, Some(index)));
        // The noise averages to nothing; rounding of a mean of 200.
        assert!((fault.size.unwrap() - size).abs() < 1e-12);
    }
}

#[test]
fn a_scalar_residual_names_no_sensor_but_sizes_each() {
    let set = hypotheses(&[&[0.5], &[-2.0]]);
    let mut rule = SizedDebounce::new(1, Debouncing::default(), &set, &Sizing::default()).unwrap();
    let decision = rule.decide(at(0, Phase::Compensating, 2.0, &[1.0]));
    assert_eq!(decision, Decision::Fault(Fault::since(0)));
    assert_eq!(rule.sizes(), [2.0, -0.5]);

    let mut alone =
        SizedDebounce::new(1, Debouncing::default(), &set[..1], &Sizing::default()).unwrap();
    let decision = alone.decide(at(0, Phase::Compensating, 2.0, &[1.0]));
    let expected = Fault { hypothesis: Some(0), size: Some(2.0), ..Fault::since(0) };
    assert_eq!(decision, Decision::Fault(expected));
    alone.decide(at(1, Phase::Compensating, 0.0, &[0.0]));
    assert_eq!(alone.sizes(), [0.0]);
}

#[test]
fn a_short_memory_follows_a_growing_fault() {
    let set = hypotheses(&[&[1.0, 0.0]]);
    let rows: Vec<[f64; 2]> = (0..500).map(|k| [0.01 * f64::from(k), 0.0]).collect();
    let size = |memory| {
        let sizing = Sizing { memory, ..Sizing::default() };
        let mut rule = SizedDebounce::new(2, Debouncing::default(), &set, &sizing).unwrap();
        last_fault(&mut rule, &rows).size.unwrap()
    };
    // The mean of a ramp is half of its end; a first-order lag of ten samples trails it by nine.
    assert!((size(None) - 0.5 * 4.99).abs() < 1e-12);
    assert!((size(Some(10.0)) - (4.99 - 0.09)).abs() < 1e-9);
}

/// Where a nonlinear model has no answer the residual is NaN for a sample.
#[test]
fn a_sample_without_a_residual_does_not_spoil_the_size() {
    let set = hypotheses(&[&[1.0, 0.0]]);
    for memory in [None, Some(10.0)] {
        let sizing = Sizing { memory, ..Sizing::default() };
        let mut rule = SizedDebounce::new(2, Debouncing::default(), &set, &sizing).unwrap();
        let size = last_fault(&mut rule, &[[2.0, 0.0], [f64::NAN, 0.0], [2.0, 0.0]]).size;
        assert_eq!(size, Some(2.0));
    }
}

#[test]
fn signatures_are_checked() {
    for bad in [&[0.0, 0.0][..], &[1.0][..], &[f64::NAN, 1.0][..]] {
        let error = SizedDebounce::<f64>::new(
            2,
            Debouncing::default(),
            &hypotheses(&[bad]),
            &Sizing::default(),
        )
        .unwrap_err();
        assert!(matches!(error, RuleError::Signature { hypothesis: 0, .. }), "{error}");
    }
}

#[test]
fn the_smallest_fault_in_closed_form() {
    let plain = Debouncing::default();
    // A response of the other sign, none at all, and a residual beyond the threshold by itself.
    assert_eq!(smallest_detectable(&[0.5], &[-1.0], 1.0, plain), Some(1.5));
    assert_eq!(smallest_detectable(&[0.5, 0.1], &[0.0, 0.0], 1.0, plain), None);
    assert_eq!(smallest_detectable(&[1.5], &[1.0], 1.0, plain), Some(0.0));
    // Two in a row: the harder of the two, at the best place.
    let two = Debouncing::consecutive(2);
    let size = smallest_detectable(&[0.0; 4], &[0.1, 0.5, 0.4, 0.1], 1.0, two);
    assert_eq!(size, Some(2.5));
    assert_eq!(smallest_detectable(&[0.0], &[1.0], 1.0, two), None);
}

#[test]
fn the_smallest_fault_by_search() {
    let healthy: Vec<f64> = (0..400).map(|k| (f64::from(k).powi(2) * 0.618).sin()).collect();
    let response: Vec<f64> = (0..400).map(|k| f64::from(u8::from(k >= 100))).collect();
    let rows = SampleRows::new(1, &healthy).unwrap();
    let step = SampleRows::new(1, &response).unwrap();
    let rule = Debouncing::consecutive(2);

    // A statistic without memory: as in closed form.
    let mut magnitude = Magnitude::new(&[1.0], 1.05).unwrap();
    let found = smallest_detectable_by_search(&mut magnitude, rule, rows, step, 9.0).unwrap();
    let closed = smallest_detectable(&healthy, &response, 1.05, rule).unwrap();
    assert!((found.unwrap() - closed).abs() < 9.0 * 2.0_f64.powi(-39));
    let far = smallest_detectable_by_search(&mut magnitude, rule, rows, step, 0.01).unwrap();
    assert_eq!(far, None);

    // A statistic with memory: the answer is the edge between unseen and seen.
    let unit = Standardizer::new(&[0.0], &[0.7]).unwrap();
    let mut sum = Cusum::new(unit, 0.5, 8.0).unwrap();
    let edge = smallest_detectable_by_search(&mut sum, rule, rows, step, 9.0).unwrap().unwrap();
    let mut is_seen = |size: f64| {
        Stage::<f64>::reset(&mut sum);
        let pairs = healthy.iter().zip(&response);
        let margins: Vec<f64> =
            pairs.map(|(r, g)| sum.update(&[], &[r + size * g]).statistic).collect();
        alarms(&margins, 8.0, rule).unwrap().contains(&true)
    };
    assert!(edge > 0.0 && is_seen(edge) && !is_seen(edge * (1.0 - 1e-6)), "{edge}");
}

#[test]
fn a_delay_counts_from_the_fault_and_not_from_earlier_alarms() {
    let statistics = [2.0, 2.0, 0.0, 2.0, 0.0, 2.0, 2.0];
    let delay =
        |fault_at| detection_delay(&statistics, 1.0, Debouncing::consecutive(2), fault_at).unwrap();
    assert_eq!(delay(0), Some(1));
    assert_eq!(delay(1), Some(5));
    assert_eq!(delay(6), None);
    assert_eq!(delay(60), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_debounce_of_one_is_the_raw_alarm(alarming in prop::collection::vec(any::<bool>(), 0..80)) {
        let mut rule = Debounce::new(1, Debouncing::default()).unwrap();
        let judged = judge(&mut rule, &alarming);
        prop_assert_eq!(judged.iter().map(Option::is_some).collect::<Vec<_>>(), alarming);
    }

    /// A fault is said to have begun with the first alarm in the window that raised it.
    #[test]
    fn a_fault_began_with_the_first_alarm_of_its_window(
        alarming in prop::collection::vec(any::<bool>(), 1..40), raise in 1_usize..5, more in 0_usize..4,
    ) {
        let out_of = raise + more;
        let window = |end: usize| (end.saturating_sub(out_of)..end).filter(|&k| alarming[k]);
        let raised = (1..=alarming.len()).find(|&end| window(end).count() >= raise);
        let began = raised.and_then(|end| window(end).next()).map(|k| k as u64);
        let (raise, out_of) = (raise as u64, out_of as u64);
        let mut rule = Debounce::new(1, Debouncing { raise, out_of, clear: 1, latch: true }).unwrap();
        prop_assert_eq!(judge(&mut rule, &alarming).into_iter().flatten().next(), began);
    }

    /// The debounced statistic exceeds the threshold exactly when enough of the window does.
    #[test]
    fn the_debounced_statistic_is_the_raise_condition(
        statistics in prop::collection::vec(0.0..2.0_f64, 1..60),
        raise in 1_u64..5, more in 0_u64..4, threshold in 0.0..2.0_f64,
    ) {
        let out_of = raise + more;
        let debouncing = Debouncing { raise, out_of, clear: 1, latch: true };
        let reduced = debounced_statistics(&statistics, debouncing);
        let replay = alarms(&statistics, threshold, debouncing).unwrap();
        // A latched alarm is raised from the first sample at which the condition holds.
        let first = reduced.iter().position(|&s| s > threshold);
        prop_assert_eq!(replay.iter().position(|&a| a), first);
    }

    #[test]
    fn alarms_are_monotone_in_the_threshold(
        statistics in prop::collection::vec(0.0..2.0_f64, 1..60),
        low in 0.0..2.0_f64, more in 0.0..1.0_f64,
    ) {
        // Without clearing rules of its own each sample is judged by its window.
        let debouncing = Debouncing { raise: 2, out_of: 3, clear: 1, latch: true };
        let at_low = alarms(&statistics, low, debouncing).unwrap();
        let at_high = alarms(&statistics, low + more, debouncing).unwrap();
        prop_assert!(at_low.iter().zip(&at_high).all(|(low, high)| *low || !high));
    }

    /// The fault of the closed form just fails to alarm, a slightly larger one does.
    #[test]
    fn the_closed_form_is_the_edge_of_detection(
        pairs in prop::collection::vec((-0.9..0.9_f64, -1.0..1.0_f64), 5..40),
        consecutive in 1_u64..4,
    ) {
        let (healthy, response): (Vec<_>, Vec<_>) = pairs.into_iter().unzip();
        let rule = Debouncing::consecutive(consecutive);
        let size = smallest_detectable(&healthy, &response, 1.0, rule).unwrap();
        let seen = |s: f64| {
            let r: Vec<f64> = healthy.iter().zip(&response).map(|(r, g)| (r + s * g).abs()).collect();
            alarms(&r, 1.0, rule).unwrap().contains(&true)
        };
        prop_assert!(seen(size * (1.0 + 1e-9)));
        prop_assert!(!seen(size * (1.0 - 1e-9)));
    }

    #[test]
    fn reset_and_restore_give_the_same_future(
        rows in prop::collection::vec((0.0..2.0_f64, -1.0..1.0_f64, any::<bool>()), 60),
        cut in 0_usize..60,
    ) {
        let set = hypotheses(&[&[1.0, 0.5], &[-0.2, 2.0]]);
        let debouncing = Debouncing { raise: 2, out_of: 3, clear: 2, latch: false };
        let sizing = Sizing { settling: 1, memory: Some(4.0), ..Sizing::default() };
        let build = || SizedDebounce::<f64>::new(2, debouncing, &set, &sizing).unwrap();
        let run = |rule: &mut SizedDebounce<f64>, range: std::ops::Range<usize>| -> Vec<_> {
            range.map(|k| {
                let (statistic, r, compensating) = rows[k];
                let phase = if compensating || k % 5 != 0 { Phase::Compensating } else { TRAINING };
                (rule.decide(at(k as u64, phase, statistic, &[r, statistic])), rule.sizes().to_vec())
            }).collect()
        };
        let mut one = build();
        let first = run(&mut one, 0..cut);
        let snapshot = Snapshot::of(&mut one);
        let second = run(&mut one, cut..60);
        let mut two = build();
        snapshot.restore(&mut two).unwrap();
        prop_assert_eq!(second, run(&mut two, cut..60));
        one.reset();
        prop_assert_eq!(first, run(&mut one, 0..cut));
    }
}
