//! What a monitor says of streams: of good ones what a study of logs says, of bad ones what is wrong.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::common::*;
use fd_model::{ResamplePolicy, TimeSeries};
use fd_watch::{Cleared, Event, Learning, Message, Monitor, Row, What, Why};
use fdiag::training::{Healthy, Trace, train};

/// Time and values of a sample.
type Sample = (f64, Vec<f64>);

/// The times at which a log raises alarms when it is studied as a whole.
fn studied(rows: &[Sample]) -> Vec<f64> {
    let model = model();
    let series = TimeSeries {
        inputs: model.input_channels(),
        outputs: model.output_channels(),
        t: rows.iter().map(|(time, _)| *time).collect(),
        u: rows.iter().flat_map(|(_, values)| values[..1].to_vec()).collect(),
        y: rows.iter().flat_map(|(_, values)| values[1..].to_vec()).collect(),
    };
    let policy = ResamplePolicy { sample_time: Some(0.1), ..ResamplePolicy::default() };
    let (record, _) = series.resample(&policy).unwrap();
    let (plant, spec) = (model.system.sampled(record.ts()).unwrap(), request_spec());
    let healthy = crate::common::record(2000, 0).scaled(&model.scaling()).unwrap();
    let trained = train(&spec, &plant, &[Healthy::split(&healthy, 0.7)]).unwrap();
    let scaled = record.scaled(&model.scaling()).unwrap();
    let trace = Trace::of(&mut trained.compensated().unwrap(), &scaled).unwrap();
    (0..trace.len())
        .filter(|&k| trace.alarm[k] && !(0 < k && trace.alarm[k - 1]))
        .map(|k| trace.time[k])
        .collect()
}

fn request_spec() -> fdiag::spec::PipelineSpec {
    request(Learning::Stream { samples: 1 }).spec
}

fn raised(messages: &[Message]) -> Vec<f64> {
    let alarm = |m: &Message| if let Message::Alarm(alarm) = m { Some(alarm.time) } else { None };
    messages.iter().filter_map(alarm).collect()
}

fn whats(messages: &[Message]) -> Vec<What> {
    let what = |m: &Message| match m {
        Message::Event(Event { what: What::Diagnosis { .. }, .. }) => None,
        Message::Event(event) => Some(event.what.clone()),
        _ => None,
    };
    messages.iter().filter_map(what).collect()
}

/// Sample by sample as in one go: on an even time base, on a jittery one, and with holes that are bridged.
#[test]
fn a_stream_is_judged_as_a_log_is() {
    let even = rows(&faulty(5));
    let mut random = Random(7);
    let jittery: Vec<_> = even
        .iter()
        .enumerate()
        .map(|(k, (time, values))| {
            let moved = if k == 0 { 0.0 } else { 0.06 * (random.next() - 0.5) };
            (time + moved, values.clone())
        })
        .collect();
    let holes: Vec<_> = even.iter().filter(|_| random.next() < 0.9).cloned().collect();
    for (name, rows) in [("even", even), ("jittery", jittery), ("with holes", holes)] {
        let mut monitor = Monitor::new(plan());
        let messages = take(&mut monitor, "p", &rows);
        let (found, expected) = (raised(&messages), studied(&rows));
        assert!(2 <= expected.len(), "{name}: {expected:?}");
        assert_eq!(found.len(), expected.len(), "{name}: {found:?} {expected:?}");
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-9, "{name}: {found} {expected}");
        }
    }
}

#[test]
fn an_alarm_says_what_where_and_since_when() {
    let mut monitor = Monitor::new(plan());
    let messages = take(&mut monitor, "p", &rows(&faulty(5)));
    let alarms: Vec<_> = messages
        .iter()
        .filter_map(|m| if let Message::Alarm(alarm) = m { Some(alarm) } else { None })
        .collect();
    let [first, _] = alarms[..] else { panic!("{alarms:?}") };
    assert!((40.0..40.5).contains(&first.since) && first.since <= first.time, "{first:?}");
    assert_eq!(first.id, format!("p/maximum/{}", first.time));
    assert!(first.threshold < first.statistic && first.residual.len() == 2);
    // What is known later is told later: 5 K at the temperature sensor.
    let told = messages.iter().rev().find_map(|m| match m {
        Message::Alarm(alarm) | Message::Update(alarm) if alarm.fault.is_some() => Some(alarm),
        _ => None,
    });
    let told = told.unwrap();
    assert_eq!(
        (told.fault.as_deref(), told.size_unit.as_deref()),
        (Some("sensor temperature"), Some("K"))
    );
    assert!(told.size.is_some_and(|size| (2.0..8.0).contains(&size)), "{told:?}");
    let cleared = messages.iter().filter(|m| matches!(m, Message::Cleared(_))).count();
    assert_eq!(cleared, 2);
}

/// Every way in which a stream can be wrong is told, and the alarms of the good samples are as without it.
#[test]
fn what_is_wrong_with_times_is_told_and_left_out() {
    let good = rows(&faulty(5));
    let expected = Monitor::new(plan());
    let expected = {
        let mut m = expected;
        take(&mut m, "p", &good)
    };
    let odd = |time: f64| (time, vec![2.0, 9e9, 9e9]);
    let with = |at: usize, odd: &[Sample]| {
        let mut rows = good.clone();
        rows.splice(at..at, odd.iter().cloned());
        rows
    };
    let newest = good[99].0;
    let cases: [(&str, Vec<Sample>, Vec<What>); 5] = [
        ("doubled", with(100, &[odd(newest)]), vec![What::Doubled { count: 1, ended: false }]),
        (
            "late",
            with(100, &[odd(newest - 0.25)]),
            vec![What::Late { count: 1, ended: false, newest }],
        ),
        (
            "backwards",
            with(100, &(0..12).map(|k| odd(0.1 * f64::from(k) - 3600.0)).collect::<Vec<_>>()),
            [(1, false), (10, false), (12, true)]
                .map(|(count, ended)| What::ClockBackwards { count, ended, newest })
                .to_vec(),
        ),
        ("ahead", with(100, &[odd(1e9)]), vec![What::ClockJumped { to: 1e9 }]),
        ("ahead at first", with(0, &[odd(1e9)]), vec![What::ClockJumped { to: 1e9 }]),
    ];
    for (name, rows, told) in cases {
        let mut monitor = Monitor::new(plan());
        let messages = take(&mut monitor, "p", &rows);
        assert_eq!(whats(&messages), told, "{name}");
        assert_eq!(promised(&messages), promised(&expected), "{name}");
        let odd = rows.len() - good.len();
        assert_eq!(monitor.counts().dropped, odd as u64, "{name}");
    }
}

#[test]
fn a_long_gap_ends_an_alarm_and_begins_anew() {
    let mut rows = rows(&faulty(5));
    // In the middle of the first fault.
    rows.drain(450..600);
    let mut monitor = Monitor::new(plan());
    let messages = take(&mut monitor, "p", &rows);
    let (from, to) = (rows[449].0, rows[450].0);
    assert!(whats(&messages).contains(&What::Gap { from, to }));
    let ended = messages.iter().find_map(|m| match m {
        Message::Cleared(Cleared { why, time, .. }) => Some((*why, *time)),
        _ => None,
    });
    let (why, time) = ended.unwrap();
    assert!(why == Why::Gap && (time - from).abs() < 1e-9);
    // The second fault is found, by a diagnosis that has settled again.
    assert_eq!(raised(&messages).len(), 2);
}

#[test]
fn missing_values_are_held_then_refused() {
    let mut rows = rows(&record(600, 5));
    rows[100..102].iter_mut().for_each(|row| row.1[2] = f64::NAN);
    rows[200..230].iter_mut().for_each(|row| row.1[0] = f64::NAN);
    let mut monitor = Monitor::new(plan());
    let messages = take(&mut monitor, "p", &rows);
    let held = |count, ended| What::Held { count, ended };
    let refused = |count, ended| What::Refused { count, ended };
    let told = [
        held(1, false),
        held(2, true),
        held(1, false),
        refused(1, false),
        refused(10, false),
        refused(27, true),
    ];
    assert_eq!(whats(&messages), told);
    assert!(promised(&messages).is_empty(), "nothing is wrong with the plant");
}

#[test]
fn a_unit_learns_from_its_own_samples() {
    let mut monitor = Monitor::new(request(Learning::Stream { samples: 2000 }).plan().unwrap());
    let mut run = record(3200, 0);
    for k in (2400..2500).chain(2800..2900) {
        run.y_mut(k)[1] += 5.0;
    }
    let all = rows(&run);
    let messages = take(&mut monitor, "p", &all);
    let whats = whats(&messages);
    assert_eq!(whats[0], What::LearningStarted { samples: 2000 });
    assert!(whats.contains(&What::Learned { samples: 2000 }), "{whats:?}");
    assert!(2 <= raised(&messages).len());
    assert!(raised(&messages).iter().all(|time| 239.0 < *time), "{:?}", raised(&messages));

    // Inputs that stand still teach nothing, and that is said.
    let mut monitor = Monitor::new(request(Learning::Stream { samples: 50 }).plan().unwrap());
    let still: Vec<_> = (0..51).map(|k| (f64::from(k) * 0.1, vec![2.0, 3000.0, 900.0])).collect();
    let messages = take(&mut monitor, "p", &still);
    assert!(
        matches!(&messages[1], Message::Event(Event { what: What::LearningFailed { reason }, .. })
        if reason.contains("no input moves")),
        "{messages:?}"
    );
}

#[test]
fn units_are_strangers_to_each_other() {
    let (a, b) = (rows(&faulty(5)), rows(&record(1200, 6)));
    let mut request = request(Learning::Logs(vec![record(2000, 0)]));
    request.most_units = 2;
    let mut monitor = Monitor::new(request.plan().unwrap());
    for (a, b) in a.iter().zip(&b) {
        for (unit, (time, values)) in [("a", a), ("b", b), ("c", b)] {
            monitor.take(Row { unit, time: *time, values }).unwrap();
        }
    }
    let messages = monitor.take_messages();
    let alone = take(&mut Monitor::new(plan()), "a", &a);
    assert_eq!(promised(&messages), promised(&alone));
    assert!(
        messages.iter().any(|m| matches!(
            m,
            Message::Event(Event { what: What::TooManyUnits { most: 2 }, .. })
        ))
    );
    assert_eq!((monitor.units().len(), monitor.counts().refused), (2, 1200));
}
