//! Laws of resampling: the identity on even data, the stated policy on the rest.

use fd_core::Limits;
use proptest::prelude::*;

use super::*;
use crate::channel::Channel;

fn series(t: &[f64], u: &[f64], y: &[f64]) -> TimeSeries {
    TimeSeries {
        inputs: Channel::numbered("u", 1),
        outputs: Channel::numbered("y", 1),
        t: t.to_vec(),
        u: u.to_vec(),
        y: y.to_vec(),
    }
}

fn bits(values: impl Iterator<Item = f64>) -> Vec<u64> {
    values.map(f64::to_bits).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn an_even_series_is_left_as_it_is(
        y in proptest::collection::vec(-1e3..1e3_f64, 2..200),
        start in -1e5..1e5_f64,
        step in 1e-3..1e3_f64,
        given in any::<bool>(),
    ) {
        let t: Vec<f64> = (0..y.len()).map(|k| start + k as f64 * step).collect();
        let policy = ResamplePolicy { sample_time: given.then_some(step), ..ResamplePolicy::default() };
        let (record, report) = series(&t, &y, &y).resample(&policy).unwrap();
        prop_assert!(report.even);
        prop_assert_eq!(bits(record.output(0)), bits(y.iter().copied()));
        prop_assert_eq!(bits(record.input(0)), bits(y.iter().copied()));
        // The step is a difference of times up to 3e5 s, divided by at least one.
        prop_assert!((record.ts().seconds() - step).abs() <= 4.0 * f64::EPSILON * 3e5);
    }

    #[test]
    fn a_straight_line_is_interpolated_exactly(
        steps in proptest::collection::vec(0.2..2.0_f64, 2..100),
        slope in -5.0..5.0_f64,
    ) {
        let t: Vec<f64> = std::iter::once(0.0)
            .chain(steps.iter().scan(0.0, |t, dt| { *t += dt; Some(*t) }))
            .collect();
        let y: Vec<f64> = t.iter().map(|t| slope * t).collect();
        let policy = ResamplePolicy { sample_time: Some(0.3), max_gap_s: Some(3.0), ..ResamplePolicy::default() };
        let (record, report) = series(&t, &t, &y).resample(&policy).unwrap();
        prop_assert!(report.gaps.is_empty());
        for k in 0..record.len() {
            let time = record.time(k);
            // A sample that is met within a thousandth of a step is taken as it is.
            prop_assert!((record.y(k)[0] - slope * time).abs() <= 5.0 * 0.3e-3 + 1e-12);
            // The held input is the time of the latest sample.
            let latest = t.iter().copied().filter(|t| *t <= time + 0.3e-3).fold(f64::MIN, f64::max);
            prop_assert_eq!(record.u(k)[0].to_bits(), latest.to_bits());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The integral of what is held is that of the samples, each held until the next one.
    #[test]
    fn a_mean_of_held_inputs_keeps_their_integral(
        rows in proptest::collection::vec((0.2..2.0_f64, -5.0..5.0_f64), 2..100),
        step in 0.1..3.0_f64,
    ) {
        let t: Vec<f64> = rows.iter().scan(0.0, |t, (dt, _)| { *t += dt; Some(*t) }).collect();
        let u: Vec<f64> = rows.iter().map(|(_, u)| *u).collect();
        let policy = ResamplePolicy {
            sample_time: Some(step),
            max_gap_s: Some(3.0),
            held_inputs: Some(HeldInputs::Mean),
            ..ResamplePolicy::default()
        };
        let (record, _) = series(&t, &u, &u).resample(&policy).unwrap();
        let end = t[0] + record.len() as f64 * step;
        let held = t.iter().zip(&u).enumerate().map(|(i, (from, u))| {
            let to = t.get(i + 1).map_or(end, |next| next.min(end));
            u * (to - from).max(0.0)
        });
        let (held, made): (f64, f64) = (held.sum(), record.input(0).map(|u| u * step).sum());
        // A sample within a thousandth of a step of a grid time counts as on it: at most 10 units over that, at each.
        prop_assert!((held - made).abs() <= 10.0 * 1e-3 * step * record.len() as f64 + 1e-9, "{held} {made}");
    }
}

#[test]
fn gaps_are_left_missing() {
    let t = [0.0, 1.0, 2.0, 5.0, 6.0, 7.0];
    let policy = ResamplePolicy { max_gap_s: Some(2.0), ..ResamplePolicy::default() };
    let (record, report) = series(&t, &t, &t).resample(&policy).unwrap();
    let missing: Vec<bool> = record.output(0).map(f64::is_nan).collect();
    assert_eq!(missing, [false, false, false, true, true, false, false, false]);
    assert_eq!(record.input(0).map(f64::is_nan).collect::<Vec<_>>(), missing);
    assert_eq!(report.gaps, [Gap { from_s: 2.0, to_s: 5.0 }]);
    assert_eq!((report.rows, report.samples, report.even), (6, 8, false));

    // The default bridges up to five steps.
    let (record, report) = series(&t, &t, &t).resample(&ResamplePolicy::default()).unwrap();
    assert_eq!(record.output(0).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    assert_eq!(record.input(0).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 2.0, 2.0, 5.0, 6.0, 7.0]);
    assert!(report.gaps.is_empty() && !report.even);
}

#[test]
fn a_fine_grid_does_not_make_gaps() {
    let t = [0.0, 1.0, 2.0];
    let policy = ResamplePolicy { sample_time: Some(0.125), ..ResamplePolicy::default() };
    let (record, report) = series(&t, &t, &t).resample(&policy).unwrap();
    assert!(report.gaps.is_empty());
    assert!(record.output(0).eq((0..17).map(|k| f64::from(k) * 0.125)));
}

#[test]
fn a_missing_value_spreads_to_what_is_made_of_it() {
    let (t, hole) = ([0.0, 1.0, 2.5, 3.0], [0.0, 1.0, f64::NAN, 3.0]);
    let (record, _) = series(&t, &hole, &hole).resample(&ResamplePolicy::default()).unwrap();
    assert_eq!(record.input(0).map(f64::is_nan).collect::<Vec<_>>(), [false; 4]);
    assert_eq!(record.output(0).map(f64::is_nan).collect::<Vec<_>>(), [false, false, true, false]);
}

#[test]
fn disorder_is_rejected_or_dropped_and_counted() {
    let t = [0.0, 1.0, 1.0, 0.5, 2.0, 3.0];
    let y = [0.0, 1.0, 8.0, 9.0, 2.0, 3.0];
    assert_eq!(
        series(&t, &y, &y).resample(&ResamplePolicy::default()),
        Err(TimeBaseError::NotIncreasing { index: 2, before: 1.0, time: 1.0 })
    );
    let policy = ResamplePolicy { disorder: Disorder::Drop, ..ResamplePolicy::default() };
    let (record, report) = series(&t, &y, &y).resample(&policy).unwrap();
    assert_eq!(record.output(0).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!((report.duplicates, report.out_of_order), (1, 1));
}

#[test]
fn impossible_series_are_errors() {
    let default = ResamplePolicy::default();
    let error = |t: &[f64], policy| series(t, t, t).resample(policy).unwrap_err().to_string();
    assert_eq!(
        error(&[1.0], &default),
        "at least 2 samples are needed to find the sample time, got 1"
    );
    assert_eq!(
        error(&[], &default),
        "at least 2 samples are needed to find the sample time, got 0"
    );
    assert_eq!(error(&[0.0, f64::NAN], &default), "sample 1: the time must be finite, got NaN s");
    assert!(error(&[0.0, 1.0, 2.0, 1e12], &default).contains("limit `samples`"));
    let policy = ResamplePolicy { tolerance: 0.5, ..default.clone() };
    assert!(error(&[0.0, 1.0], &policy).starts_with("resampling: `tolerance` must be"));
    let short = TimeSeries { y: vec![1.0], ..series(&[0.0, 1.0], &[0.0, 1.0], &[]) };
    assert!(matches!(short.resample(&default), Err(TimeBaseError::Model(_))));
    // One sample is enough when the step is given.
    let policy = ResamplePolicy { sample_time: Some(1.0), ..default };
    assert_eq!(series(&[1.0], &[1.0], &[1.0]).resample(&policy).unwrap().0.len(), 1);
}

#[test]
fn a_clock_that_jumps_and_a_grid_that_is_too_fine_are_refused_by_the_limit() {
    let t = [0.0, 0.01, 0.02, 1e6, 1e6 + 0.01];
    let y = [0.0; 5];
    let error = series(&t, &y, &y).resample(&ResamplePolicy::default()).unwrap_err().to_string();
    let words = "samples on an even time base: expected at most 10000000 samples (limit `samples`), \
                 found 100000002; 1000000.01 s in steps of 0.01 s, the longest without a sample \
                 999999.98 s after 0.02 s";
    // The median step is 0.01 s but for rounding.
    assert!(error.starts_with(&words[..80]) && error.ends_with("s after 0.02 s"), "{error}");

    let t = [0.0, 1.0, 2.0, 3.0];
    let policy = ResamplePolicy {
        sample_time: Some(1e-2),
        limits: Limits { samples: 300, ..Limits::default() },
        ..ResamplePolicy::default()
    };
    let error = series(&t, &t, &t).resample(&policy).unwrap_err();
    assert!(matches!(&error, TimeBaseError::TooLong { limit, .. } if limit.most == 300), "{error}");
    let limits = Limits { samples: 301, ..Limits::default() };
    let (record, _) = series(&t, &t, &t).resample(&ResamplePolicy { limits, ..policy }).unwrap();
    assert_eq!(record.len(), 301);
}

/// Where somebody has lifted the limit of samples, what the time base needs is reserved against the budget of memory.
#[test]
fn a_time_base_beyond_the_memory_is_refused() {
    let t = [0.0, 1.0, 2.0];
    let limits = Limits { samples: u64::MAX, ..Limits::default() };
    let policy = ResamplePolicy { sample_time: Some(1e-12), limits, ..ResamplePolicy::default() };
    let error = series(&t, &t, &t).resample(&policy).unwrap_err();
    // Two channels of 2e12 samples and one.
    assert!(matches!(error, TimeBaseError::Memory(_)), "{error}");
    assert!(error.to_string().contains("found 32000000000016"), "{error}");
}

/// Four samples a second, with stamps of one digit: rounded half up, or cut off.
#[test]
fn times_that_are_rounded_are_even() {
    let counts = 0..200_u32;
    let rounded: Vec<f64> = counts.clone().map(|k| (f64::from(k) * 2.5).round() / 10.0).collect();
    let cut: Vec<f64> = counts.clone().map(|k| (f64::from(k) * 2.5).floor() / 10.0).collect();
    let y: Vec<f64> = counts.map(|k| f64::from(k).sin()).collect();
    for t in [rounded, cut] {
        let (record, report) = series(&t, &y, &y).resample(&ResamplePolicy::default()).unwrap();
        // The last stamp is off by a digit at most.
        assert!((record.ts().seconds() - 0.25).abs() <= 0.1 / 199.0, "{report:?}");
        assert!(report.even);
        assert_eq!(bits(record.input(0)), bits(y.iter().copied()));
    }
}

/// What jitters by more than the last digit does jitter.
#[test]
fn times_that_jitter_are_not_even() {
    let t: Vec<f64> = (0..200_u32).map(|k| f64::from(25 * k + 3 * (k % 3)) / 100.0).collect();
    let (_, report) = series(&t, &t, &t).resample(&ResamplePolicy::default()).unwrap();
    assert!(!report.even);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// An input that was measured is on the line through its samples, as outputs are.
    #[test]
    fn inputs_are_interpolated_where_that_is_asked(
        steps in proptest::collection::vec(0.2..2.0_f64, 2..100),
        values in proptest::collection::vec(-5.0..5.0_f64, 101),
    ) {
        let t: Vec<f64> = std::iter::once(0.0)
            .chain(steps.iter().scan(0.0, |t, dt| { *t += dt; Some(*t) }))
            .collect();
        let y = &values[..t.len()];
        let held_inputs = Some(HeldInputs::Linear);
        let policy = ResamplePolicy { sample_time: Some(0.3), held_inputs, ..ResamplePolicy::default() };
        let (record, _) = series(&t, y, y).resample(&policy).unwrap();
        prop_assert_eq!(bits(record.input(0)), bits(record.output(0)));
    }
}
