//! Answers that are given on the page: whether to train a unit again.

use std::{sync::mpsc::sync_channel, time::Duration};

use serde::Deserialize;

use super::{gate::Gate, head::Head, line::Line, refusal::Refusal};
use crate::board::{Answer, Board};

/// Longest answer in bytes; the name of a unit has at most 200 characters.
const LONGEST: usize = 4096;
/// Longest time until the monitor has dealt with an answer.
const PATIENCE: Duration = Duration::from_secs(10);

/// What is posted.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Posted {
    id: String,
    answer: Said,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Said {
    Confirm,
    Refuse,
}

/// Takes an answer, and waits until the monitor has kept it.
pub(super) fn take(
    head: &Head,
    line: &mut Line,
    gate: &Gate,
    board: &Board,
) -> Result<(), Refusal> {
    gate.may_answer(head)?;
    let kind = head.field("Content-Type")?.unwrap_or_default();
    if !kind.starts_with("application/json") {
        return Err(Refusal(415, "expected Content-Type: application/json".to_owned()));
    }
    let length = head.length()?;
    if LONGEST < length {
        return Err(Refusal(413, format!("expected at most {LONGEST} bytes, found {length}")));
    }
    let body = line.body(length)?;
    let posted: Posted = serde_json::from_slice(&body).map_err(|error| {
        let why = "expected {\"id\": ..., \"answer\": \"confirm\" or \"refuse\"}";
        Refusal(400, format!("{why}: {error}"))
    })?;
    let (heard, outcome) = sync_channel(1);
    let answer = Answer { id: posted.id, confirmed: matches!(posted.answer, Said::Confirm), heard };
    let outcome = if board.put_answer(answer) { outcome.recv_timeout(PATIENCE).ok() } else { None };
    match outcome {
        Some(outcome) => outcome.map_err(|why| Refusal(409, why)),
        None => Err(Refusal(503, "the monitor is busy; try again".to_owned())),
    }
}
