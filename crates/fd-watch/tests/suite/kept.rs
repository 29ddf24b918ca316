//! Samples that a source was told to forget, and a journal that a second listener hears late.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{fs, path::Path};

use crate::common::*;
use fd_watch::{Message, Monitor, Row, StateError, StateFolder};

/// Takes rows as they come from a source that does not repeat itself.
fn keep(state: &mut StateFolder, monitor: &mut Monitor, rows: &[(f64, Vec<f64>)]) -> Vec<Message> {
    for (time, values) in rows {
        let row = Row { unit: "p", time: *time, values };
        monitor.take(row).unwrap();
        state.keep(row);
    }
    state.secure(monitor).unwrap();
    let mut messages = monitor.take_messages();
    state.promise(&mut messages).unwrap();
    messages
}

fn open(folder: &Path) -> (StateFolder, Monitor, Vec<Message>) {
    let mut monitor = Monitor::new(plan());
    let (mut state, mut messages) = StateFolder::open(folder, &mut monitor).unwrap();
    state.replay(&mut monitor, Monitor::take).unwrap().unwrap();
    let mut again = monitor.take_messages();
    state.promise(&mut again).unwrap();
    messages.extend(again);
    (state, monitor, messages)
}

fn files(folder: &Path) -> usize {
    fs::read_dir(folder.join("samples")).unwrap().count()
}

#[test]
fn each_sample_is_judged_once_wherever_the_monitor_was_killed() {
    let rows = rows(&faulty(5));
    let whole = take(&mut Monitor::new(plan()), "p", &rows);
    let expected: Vec<String> = promised(&whole).into_iter().filter_map(Message::key).collect();
    assert_eq!(expected.len(), 4, "two alarms and their ends");
    // Saved at none, some or all of the kills, which come before, in and after the faults.
    for saves in [0, 0b0101, 0b1111_u32] {
        let folder = tempfile::tempdir().unwrap();
        let (mut said, mut begin) = (Vec::new(), 0);
        for (n, end) in [300, 401, 450, 810, 1200].into_iter().enumerate() {
            let (mut state, mut monitor, again) = open(folder.path());
            said.extend(again);
            said.extend(keep(&mut state, &mut monitor, &rows[begin..end]));
            if saves >> n & 1 == 1 {
                state.save(&mut monitor, 1).unwrap();
                assert_eq!(files(folder.path()), 0, "all is in the memory of the unit");
            } else {
                assert!(0 < files(folder.path()));
            }
            begin = end;
        }
        let mut keys: Vec<String> = promised(&said).into_iter().filter_map(Message::key).collect();
        keys.sort();
        keys.dedup();
        let mut expected = expected.clone();
        expected.sort();
        assert_eq!(keys, expected, "{saves:b}");
    }
}

#[test]
fn what_was_cut_off_was_not_promised_and_what_is_damaged_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (mut state, mut monitor, _) = open(folder.path());
    keep(&mut state, &mut monitor, &rows(&faulty(5))[..10]);
    drop((state, monitor));
    let path = folder.path().join("samples/0.ndjson");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 3]).unwrap();
    let (state, monitor, _) = open(folder.path());
    assert_eq!(monitor.counts().rows, 9);
    drop((state, monitor));
    fs::write(&path, [b"nonsense\n", &bytes[..]].concat()).unwrap();
    let mut monitor = Monitor::new(plan());
    let (mut state, _) = StateFolder::open(folder.path(), &mut monitor).unwrap();
    let error = state.replay(&mut monitor, Monitor::take).unwrap_err();
    assert!(matches!(error, StateError::Damaged { .. }), "{error}");
    assert!(error.to_string().contains("0.ndjson: line 1"), "{error}");
}

#[test]
fn a_second_listener_hears_the_journal_once_and_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let (mut state, mut monitor, _) = open(folder.path());
    let said = keep(&mut state, &mut monitor, &rows(&faulty(5)));
    let said: Vec<Message> = promised(&said).into_iter().cloned().collect();
    let mut outbox = state.outbox().unwrap();
    assert_eq!(outbox.next(state.promised(), 3).unwrap(), said[..3]);
    // Not confirmed: it hears them again, also from another monitor.
    assert_eq!(outbox.next(state.promised(), 1).unwrap(), said[..1]);
    outbox.confirm().unwrap();
    let mut outbox = state.outbox().unwrap();
    assert_eq!(outbox.next(state.promised(), 9).unwrap(), said[1..]);
    outbox.confirm().unwrap();
    assert!(outbox.next(state.promised(), 9).unwrap().is_empty());
    assert_eq!(outbox.confirmed(), state.promised());
    // A journal that was moved away begins anew, and so does whoever hears it.
    state.save(&mut monitor, 1).unwrap();
    drop((state, monitor));
    fs::remove_file(folder.path().join("journal.ndjson")).unwrap();
    let (state, ..) = open(folder.path());
    assert_eq!(state.outbox().unwrap().confirmed(), 0);
}

#[test]
fn a_state_has_a_name_that_lasts_and_no_other_has() {
    let (one, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let name = |folder: &Path| open(folder).0.name().unwrap();
    assert_eq!(name(one.path()), name(one.path()));
    assert_ne!(name(one.path()), name(other.path()));
}
