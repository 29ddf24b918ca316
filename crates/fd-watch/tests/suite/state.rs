//! What is saved comes back to the bit, and what is not one's own is refused.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a failure here is a failed test; bytes by random numbers"
)]

use std::{fs, path::Path};

use crate::common::*;
use fd_watch::{Learning, Message, Monitor, Plan, StateError, StateFolder, What};

/// Rows with everything that a clock remembers: a jump that is not yet confirmed, holes, values that are missing.
fn eventful() -> Vec<(f64, Vec<f64>)> {
    let mut rows = rows(&faulty(5));
    rows.insert(420, (1e6, vec![2.0, 1.0, 1.0]));
    rows.drain(600..603);
    rows.drain(700..790);
    rows[850].1[1] = f64::NAN;
    rows
}

/// Runs rows through monitors that are stopped and restored at these rows, each of which sees the rows from the
/// beginning, as a source that repeats itself.
fn interrupted(plan: impl Fn() -> Plan, rows: &[(f64, Vec<f64>)], at: &[usize]) -> Vec<Message> {
    let folder = tempfile::tempdir().unwrap();
    let mut all = Vec::new();
    for end in at.iter().copied().chain([rows.len()]) {
        let mut monitor = Monitor::new(plan());
        let (mut state, unsure) = StateFolder::open(folder.path(), &mut monitor).unwrap();
        assert!(unsure.is_empty(), "all was saved after it was published");
        let mut messages = take(&mut monitor, "p", &rows[..end]);
        state.promise(&mut messages).unwrap();
        all.extend(messages);
        state.save(&mut monitor, usize::MAX).unwrap();
    }
    all
}

#[test]
fn a_monitor_that_was_stopped_anywhere_goes_on_to_the_bit() {
    let rows = eventful();
    let whole = take(&mut Monitor::new(plan()), "p", &rows);
    assert!(5 <= promised(&whole).len(), "{:?}", promised(&whole));
    for at in
        [&[1][..], &[405], &[421], &[422, 423], &[601, 700, 701, 850, 851], &[0, 0, 1199 - 93]]
    {
        let parts = interrupted(plan, &rows, at);
        assert_eq!(promised(&parts), promised(&whole), "{at:?}");
    }
}

#[test]
fn also_while_it_learns_and_with_what_it_has_learned() {
    let plan = || request(Learning::Stream { samples: 1500 }).plan().unwrap();
    let mut rows = rows(&record(1500, 0));
    let later = crate::common::rows(&faulty(5)).into_iter();
    rows.extend(later.map(|(time, values)| (150.0 + time, values)));
    let whole = take(&mut Monitor::new(plan()), "p", &rows);
    assert!(2 <= promised(&whole).len());
    let parts = interrupted(plan, &rows, &[700, 1501, 1910]);
    assert_eq!(promised(&parts), promised(&whole));
}

/// An alarm that was promised and perhaps not published is told again, once, whatever comes after.
#[test]
fn what_was_promised_is_told_again() {
    let folder = tempfile::tempdir().unwrap();
    let rows = rows(&faulty(5));
    let mut monitor = Monitor::new(plan());
    let (mut state, _) = StateFolder::open(folder.path(), &mut monitor).unwrap();
    take(&mut monitor, "p", &rows[..300]);
    state.save(&mut monitor, 1).unwrap();
    let mut lost = take(&mut monitor, "p", &rows[300..450]);
    state.promise(&mut lost).unwrap();
    let lost: Vec<Message> = promised(&lost).into_iter().cloned().collect();
    assert!(!lost.is_empty());
    // Killed here: journalled, not published, not saved. The last line was being written.
    drop(state);
    let journal = folder.path().join("journal.ndjson");
    let mut text = fs::read_to_string(&journal).unwrap();
    text.push_str(r#"{"type":"alarm","id":"p/max"#);
    fs::write(&journal, text).unwrap();

    let mut monitor = Monitor::new(plan());
    let (mut state, unsure) = StateFolder::open(folder.path(), &mut monitor).unwrap();
    assert_eq!(unsure, lost);
    let mut again = take(&mut monitor, "p", &rows[..450]);
    assert_eq!(promised(&again), lost.iter().collect::<Vec<_>>(), "the replay finds it as well");
    state.promise(&mut again).unwrap();
    assert!(promised(&again).is_empty(), "but it was told");
    assert!(
        again
            .iter()
            .any(|m| matches!(m, Message::Event(e) if e.what == What::Resumed { seen: 300 }))
    );
    let lines = fs::read_to_string(&journal).unwrap();
    assert_eq!(lines.lines().count(), lost.len(), "and stands in the journal once");
}

fn refusal(folder: &Path, plan: Plan) -> String {
    StateFolder::open(folder, &mut Monitor::new(plan)).unwrap_err().to_string()
}

#[test]
fn a_state_of_something_else_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut monitor = Monitor::new(plan());
    let (mut state, _) = StateFolder::open(folder, &mut monitor).unwrap();
    take(&mut monitor, "p", &rows(&record(100, 1)));
    state.save(&mut monitor, 1).unwrap();
    assert!(refusal(folder, plan()).contains("another monitor runs on this state"));
    drop(state);

    let mut other = request(Learning::Logs(vec![record(2000, 0)]));
    other.spec.rule.raise = 4;
    other.spec.rule.out_of = 4;
    assert!(refusal(folder, other.plan().unwrap()).contains("another spec"));
    let other = request(Learning::Logs(vec![record(2001, 0)])).plan().unwrap();
    assert!(refusal(folder, other).contains("another healthy samples"));
    let mut other = request(Learning::Logs(vec![record(2000, 0)]));
    other.model.outputs[0].scale.scale = Some(101.0);
    assert!(refusal(folder, other.plan().unwrap()).contains("another model"));
    let kept = fs::read_to_string(folder.join("state.json")).unwrap();
    fs::write(folder.join("state.json"), kept.replace("0.1.0", "0.0.9")).unwrap();
    assert!(refusal(folder, plan()).contains("expected the sum"), "nobody edits it by hand");
}

/// Any change of a byte is found, and so is a file that is cut off.
#[test]
fn a_damaged_unit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut monitor = Monitor::new(plan());
    let (mut state, _) = StateFolder::open(folder.path(), &mut monitor).unwrap();
    take(&mut monitor, "line 1/unit ä", &rows(&record(100, 1)));
    state.save(&mut monitor, 1).unwrap();
    drop(state);
    let path = folder.path().join("units/line%201%2Funit%20%C3%A4.unit");
    let good = fs::read(&path).unwrap();
    let mut random = Random(3);
    for _ in 0..40 {
        let mut bad = good.clone();
        let at = (random.next() * good.len() as f64) as usize;
        bad[at] ^= 1 << ((random.next() * 7.0) as u32);
        fs::write(&path, &bad).unwrap();
        let error = StateFolder::open(folder.path(), &mut Monitor::new(plan())).unwrap_err();
        assert!(matches!(error, StateError::Damaged { .. }), "byte {at}: {error}");
    }
    for length in [0, 10, good.len() / 2, good.len() - 1] {
        fs::write(&path, &good[..length]).unwrap();
        assert!(StateFolder::open(folder.path(), &mut Monitor::new(plan())).is_err());
    }
    fs::write(&path, &good).unwrap();
    assert!(StateFolder::open(folder.path(), &mut Monitor::new(plan())).is_ok());
}
