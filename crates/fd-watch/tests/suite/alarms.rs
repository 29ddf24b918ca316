//! Alarms as people of a plant know them: one fault is one alarm, many of one cause are one flood, and a journal can be
//! looked through afterwards.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::common::*;
use fd_model::Record;
use fd_watch::{
    AlarmSettings, Audit, Event, Learning, Message, Monitor, Plan, Reason, Row, Shelf, StateFolder,
    What,
};

/// Minutes of a sensor that is wrong by about as much as the threshold, so that noise decides at each sample.
fn chattering() -> Record {
    let mut record = record(6000, 5);
    for k in 600..6000 {
        record.y_mut(k)[1] += 1.1 + (0.3 * k as f64).sin();
    }
    record
}

fn plan_with(alarms: AlarmSettings) -> Plan {
    let request = request(Learning::Logs(vec![record(2000, 0)]));
    fd_watch::Request { alarms, ..request }.plan().unwrap()
}

fn told(alarms: AlarmSettings) -> Vec<Message> {
    take(&mut Monitor::new(plan_with(alarms)), "p", &rows(&chattering()))
}

#[test]
fn one_persistent_fault_is_one_alarm() {
    let each = told(AlarmSettings::immediate());
    let each = promised(&each);
    assert!(100 < each.len(), "{}: the fault is meant to chatter", each.len());
    let one = told(AlarmSettings::default());
    let one = promised(&one);
    let new = one.iter().filter(|message| matches!(message, Message::Alarm(_))).count();
    assert!(new == 1 && one.len() <= 6, "{one:?}");
    // It is as early as without delays.
    assert_eq!(one[0].time(), each[0].time());
}

/// Whoever is stopped and started at any sample says what one monitor says that runs through.
#[test]
fn delays_survive_a_restart() {
    let settings = AlarmSettings { off_delay_s: 5.0, hold_s: 30.0, ..AlarmSettings::default() };
    let all = rows(&faulty(5));
    let mut one = Monitor::new(plan_with(settings.clone()));
    let expected = take(&mut one, "p", &all);
    let folder = tempfile::tempdir().unwrap();
    let mut found = Vec::new();
    // Within the first fault, its off-delay, and the hold after it.
    let cuts = [0, 420, 520, 600, all.len()];
    for part in cuts.windows(2) {
        let mut monitor = Monitor::new(plan_with(settings.clone()));
        let (mut state, unsure) = StateFolder::open(folder.path(), &mut monitor).unwrap();
        assert!(unsure.is_empty());
        let mut messages = take(&mut monitor, "p", &all[part[0]..part[1]]);
        state.promise(&mut messages).unwrap();
        state.save(&mut monitor, usize::MAX).unwrap();
        found.extend(messages);
    }
    let (found, expected) = (promised(&found), promised(&expected));
    assert_eq!(found, expected);
    let why = |message: &&Message| match message {
        Message::Update(alarm) => Some(alarm.why),
        _ => None,
    };
    assert!(found.iter().filter_map(why).any(|why| why == Reason::Returned), "{found:?}");
}

#[test]
fn what_is_shelved_is_told_when_the_shelf_ends() {
    let shelf = Shelf { unit: "p".into(), from_s: 30.0, until_s: 45.0 };
    let settings = AlarmSettings { shelved: vec![shelf], ..AlarmSettings::immediate() };
    let mut monitor = Monitor::new(plan_with(settings));
    let messages = take(&mut monitor, "p", &rows(&faulty(5)));
    let first = promised(&messages)[0];
    let Message::Alarm(alarm) = first else { panic!("{first:?}") };
    assert!((45.0..45.2).contains(&alarm.time) && (40.0..40.5).contains(&alarm.since), "{alarm:?}");
}

/// A thousand units fail at once, the last of them first by its clock.
#[test]
fn a_thousand_alarms_of_one_cause_are_one_flood() {
    let mut monitor = Monitor::new(plan_with(AlarmSettings::default()));
    let board = fd_watch::Board::default();
    let rows = rows(&faulty(5));
    let units: Vec<String> = (0..1000).map(|i| format!("p{i}")).collect();
    for (time, values) in &rows[..450] {
        for (i, unit) in units.iter().enumerate() {
            let time = if i == 999 { time - 0.05 } else { *time };
            monitor.take(Row { unit, time, values }).unwrap();
        }
    }
    let messages = monitor.take_messages();
    board.say(&messages);
    let raised = |m: &&Message| matches!(m, Message::Alarm(_));
    assert_eq!(messages.iter().filter(raised).count(), 1000);
    let floods: Vec<_> = messages
        .iter()
        .filter_map(|m| match m {
            Message::Event(Event {
                what: What::Flood { cause, first_out, units, ended, .. },
                ..
            }) => Some((cause.as_str(), first_out.as_str(), *units, *ended)),
            _ => None,
        })
        .collect();
    let counts: Vec<u64> = floods.iter().map(|flood| flood.2).collect();
    assert_eq!(counts, [10, 100, 1000], "{floods:?}");
    assert_eq!((floods[2].1, floods[2].3), ("p999", false));

    let mut audit = Audit::default();
    for message in &messages {
        audit.take(message);
    }
    assert_eq!((audit.alarms(), audit.standing(), audit.most_in_ten_minutes()), (1000, 1000, 1000));
    assert_eq!((audit.causes().len(), audit.causes()[0].first_out.as_str()), (1, "p999"));
}

#[test]
fn a_journal_tells_what_was_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut monitor = Monitor::new(plan_with(AlarmSettings::immediate()));
    let (mut state, _) = StateFolder::open(folder.path(), &mut monitor).unwrap();
    let mut messages = take(&mut monitor, "p", &rows(&faulty(5)));
    state.promise(&mut messages).unwrap();
    let journal = std::fs::read(folder.path().join("journal.ndjson")).unwrap();
    // The last line was cut off by a kill.
    let audit = Audit::read(&[&journal[..], b"{\"type\":\"ala"].concat()[..]).unwrap();
    assert_eq!((audit.alarms(), audit.standing()), (2, 0));
    let text = audit.to_string();
    for part in ["2 alarms", "sensor temperature", "normal", "1 lines that are no message"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// The settings in the documentation are the defaults.
#[test]
fn documented_settings_are_the_defaults() {
    let page = include_str!("../../../../docs/watch.md");
    let text = page.split("```toml").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    assert_eq!(AlarmSettings::parse(text).unwrap(), AlarmSettings::default());
    let refused = |text: &str| AlarmSettings::parse(text).unwrap_err().to_string();
    assert!(
        refused("off_delay_s = -1.0")
            .contains("off_delay_s: expected seconds, 0 or more, found -1")
    );
    assert!(refused("severities = [3.0, 2.0]").contains("severities"));
    assert!(refused("of_delay_s = 1.0").contains("off_delay_s"), "the known keys are listed");
}
