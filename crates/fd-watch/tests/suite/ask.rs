//! Training again is asked for, and done only when somebody says so.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::common::*;
use fd_core::EventKind;
use fd_watch::{Learning, Message, Monitor, Plan, Request, StateFolder, What};

const POLICY: &str =
    "compensation.operating_point = { policy = { kind = \"retrain\" }, time_constant = 20 }\n";

fn asking(ask: bool) -> Plan {
    let spec = toml::from_str(&(POLICY.to_owned() + SPEC)).unwrap();
    let learning = Learning::Logs(vec![record(2000, 0)]);
    Request { spec, ask, ..request(learning) }.plan().unwrap()
}

/// The input leaves the range that was trained at row 400, and comes back at row 900.
fn moved() -> Vec<(f64, Vec<f64>)> {
    let mut rows = rows(&record(1200, 4));
    rows[400..900].iter_mut().for_each(|(_, values)| values[0] += 5.0);
    rows
}

fn events(messages: &[Message]) -> Vec<What> {
    let event = |message: &Message| match message {
        Message::Event(event) => Some(event.what.clone()),
        _ => None,
    };
    messages.iter().filter_map(event).collect()
}

fn count(events: &[What], is: impl Fn(&What) -> bool) -> usize {
    events.iter().filter(|what| is(what)).count()
}

fn begins(what: &What) -> bool {
    matches!(what, What::Diagnosis { what: EventKind::TrainingStarted })
}

fn id(events: &[What]) -> String {
    let ids: Vec<&String> = events
        .iter()
        .filter_map(|what| if let What::RetrainingWanted { id } = what { Some(id) } else { None })
        .collect();
    assert_eq!(ids.len(), 1, "asked once: {events:?}");
    ids[0].clone()
}

#[test]
fn without_an_answer_nothing_is_trained_and_the_question_is_taken_back() {
    let unasked = events(&take(&mut Monitor::new(asking(false)), "p", &moved()));
    assert!(1 <= count(&unasked, begins), "{unasked:?}");

    let asked = events(&take(&mut Monitor::new(asking(true)), "p", &moved()));
    assert_eq!(count(&asked, begins), 0, "{asked:?}");
    let id = id(&asked);
    assert!(asked.contains(&What::RetrainingWithdrawn { id }), "{asked:?}");
}

#[test]
fn an_answer_counts_once_and_a_question_survives_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let rows = moved();
    let mut monitor = Monitor::new(asking(true));
    let (mut state, _) = StateFolder::open(folder.path(), &mut monitor).unwrap();
    let first = events(&take(&mut monitor, "p", &rows[..600]));
    let id = id(&first);
    state.save(&mut monitor, 1).unwrap();
    drop(state);

    // Whether somebody is asked is no part of whose state it is.
    let mut unasked = Monitor::new(asking(false));
    let (state, _) = StateFolder::open(folder.path(), &mut unasked).unwrap();
    drop(state);

    let mut monitor = Monitor::new(asking(true));
    let (mut state, _) = StateFolder::open(folder.path(), &mut monitor).unwrap();
    assert_eq!(monitor.units().next().unwrap().wish, Some(id.as_str()));
    assert_eq!(monitor.answer("p/retraining/1", true), None);
    assert_eq!(monitor.answer(&id, true), Some("p"));
    assert_eq!(monitor.answer(&id, true), None, "it is answered");
    let said = events(&monitor.take_messages());
    assert_eq!(said, [What::RetrainingAnswered { id: id.clone(), confirmed: true }]);
    state.save_answered(&mut monitor).unwrap();
    drop(state);

    // The answer was kept: a monitor that goes on from there trains.
    let mut monitor = Monitor::new(asking(true));
    let (_state, _) = StateFolder::open(folder.path(), &mut monitor).unwrap();
    assert_eq!(monitor.units().next().unwrap().wish, None);
    let later = events(&take(&mut monitor, "p", &rows[600..640]));
    assert_eq!(count(&later, begins), 1, "{later:?}");
}

#[test]
fn what_is_refused_is_not_asked_again_while_it_lasts() {
    let mut monitor = Monitor::new(asking(true));
    let rows = moved();
    let id = id(&events(&take(&mut monitor, "p", &rows[..600])));
    assert_eq!(monitor.answer(&id, false), Some("p"));
    let said = events(&monitor.take_messages());
    assert_eq!(said, [What::RetrainingAnswered { id, confirmed: false }]);
    let later = events(&take(&mut monitor, "p", &rows[600..]));
    let asks = |what: &What| {
        matches!(what, What::RetrainingWanted { .. } | What::RetrainingWithdrawn { .. })
    };
    assert_eq!((count(&later, begins), count(&later, asks)), (0, 0), "{later:?}");
}
