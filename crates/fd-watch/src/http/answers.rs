//! Answers that are given on the page: whether to train a unit again.

use std::{
    io::{self, Read},
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
        mpsc::sync_channel,
    },
    time::Duration,
};

use serde::Deserialize;
use tiny_http::Request;

use super::text;
use crate::board::{Answer, Board};

/// Answers that are dealt with at once.
const AT_ONCE: usize = 5;
/// Longest answer in bytes; the name of a unit has at most 200 characters.
const LONGEST: u64 = 4096;
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

/// Takes an answer. A thread of its own waits until the monitor has kept it.
pub(super) fn take(
    request: Request,
    board: &Arc<Board>,
    waiting: &Arc<AtomicUsize>,
) -> io::Result<()> {
    // A page of somebody else can make a browser post, but not with this type: it would have to be allowed first.
    let is_json = request.headers().iter().any(|header| {
        header.field.equiv("Content-Type") && header.value.as_str().starts_with("application/json")
    });
    if !is_json {
        return request.respond(text(
            415,
            "text/plain",
            "expected Content-Type: application/json\n",
        ));
    }
    if AT_ONCE <= waiting.fetch_add(1, Ordering::Relaxed) {
        waiting.fetch_sub(1, Ordering::Relaxed);
        return request.respond(text(503, "text/plain", "too many answers at once\n"));
    }
    let (board, waiting) = (Arc::clone(board), Arc::clone(waiting));
    std::thread::spawn(move || {
        let _ = hand_over(request, &board);
        waiting.fetch_sub(1, Ordering::Relaxed);
    });
    Ok(())
}

fn hand_over(mut request: Request, board: &Board) -> io::Result<()> {
    let mut body = Vec::new();
    request.as_reader().take(LONGEST).read_to_end(&mut body)?;
    let posted: Posted = match serde_json::from_slice(&body) {
        Ok(posted) => posted,
        Err(error) => {
            let why = format!(
                "expected {{\"id\": ..., \"answer\": \"confirm\" or \"refuse\"}}: {error}\n"
            );
            return request.respond(text(400, "text/plain", &why));
        }
    };
    let (heard, outcome) = sync_channel(1);
    let answer = Answer { id: posted.id, confirmed: matches!(posted.answer, Said::Confirm), heard };
    let outcome = if board.put_answer(answer) { outcome.recv_timeout(PATIENCE).ok() } else { None };
    match outcome {
        Some(Ok(())) => request.respond(text(200, "text/plain", "kept\n")),
        Some(Err(why)) => request.respond(text(409, "text/plain", &format!("{why}\n"))),
        None => request.respond(text(503, "text/plain", "the monitor is busy; try again\n")),
    }
}
