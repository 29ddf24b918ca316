//! A unit that moves away from its model is studied, and nobody waits for that.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]
#![allow(clippy::format_collect, reason = "a short stream")]

use std::{
    collections::BTreeMap,
    io::{BufRead, BufReader, Write},
    time::{Duration, Instant},
};

use crate::watching::{Plant, promised, text};
use fd_watch::{Event, Message, What};

const WATCH: &str = "watch --model model.toml --spec spec.toml --healthy healthy.csv";

/// Six periods of 200 s in which the gain of a sensor falls.
fn stream(plant: &str) -> String {
    let samples = 12_000;
    let run = Plant::run_of(samples, 3);
    (0..samples)
        .map(|k| {
            let (u, y) = (run.u(k)[0], run.y(k));
            let gain = 1.0 - 0.5 * (k as f64 / samples as f64);
            let time = 0.1 * k as f64;
            format!(
                "{{\"rig\":\"{plant}\",\"time\":{time},\"fuel\":{u},\"speed\":{},\"temperature\":{}}}\n",
                gain * y[0],
                y[1]
            )
        })
        .collect()
}

fn event(line: &str) -> Option<Event> {
    match serde_json::from_str(line).unwrap() {
        Message::Event(event) => Some(event),
        _ => None,
    }
}

#[test]
fn a_unit_that_moves_away_for_long_is_studied_and_nobody_waits() {
    let plant = Plant::new();
    let stream = stream("a");
    let plain = plant.run(WATCH, &stream);
    let line = format!("{WATCH} --diagnose 0.0556 --diagnose-samples 300 --unit rig");
    let mut child = plant.spawn(&line);
    let mut stdin = child.stdin.take().unwrap();
    let mut out = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    stdin.write_all(stream.as_bytes()).unwrap();
    stdin.flush().unwrap();
    let mut said = String::new();
    let mut until = |is: &dyn Fn(&What) -> bool, said: &mut String| loop {
        let line = out.next().unwrap();
        said.push_str(&line);
        said.push('\n');
        if let Some(event) = event(&line)
            && is(&event.what)
        {
            return event;
        }
    };
    let begun = until(&|what| matches!(what, What::GapStudyStarted { .. }), &mut said);
    assert_eq!(
        (begun.unit.as_deref(), begun.what),
        (Some("a"), What::GapStudyStarted { samples: 300 })
    );

    // While it is studied, samples are judged as fast as ever: a new unit says at once that it has a hole.
    let asked = Instant::now();
    for time in [0.0, 0.1, 0.2, 50.0, 50.1] {
        writeln!(
            stdin,
            "{{\"rig\":\"b\",\"time\":{time},\"fuel\":0,\"speed\":0,\"temperature\":0}}"
        )
        .unwrap();
    }
    stdin.flush().unwrap();
    let is_gap = |what: &What| {
        matches!(what, What::Gap { .. } | What::GapStudied { .. } | What::GapStudyFailed { .. })
    };
    let first = until(&is_gap, &mut said);
    let waited = asked.elapsed();
    assert_eq!(first.unit.as_deref(), Some("b"), "before the study is done: {first:?}");
    assert!(waited < Duration::from_secs(2), "{waited:?}");

    let is_done =
        |what: &What| matches!(what, What::GapStudied { .. } | What::GapStudyFailed { .. });
    let answer = until(&is_done, &mut said);
    let What::GapStudied { answer } = answer.what else { panic!("{answer:?}") };
    assert!(!answer.is_empty());
    drop(stdin);
    assert!(child.wait().unwrap().success());

    // And it changes nothing of what is found.
    let (mut with, mut without) = (BTreeMap::new(), BTreeMap::new());
    let of_a = |text: String| -> String {
        text.replace("\"plant\"", "\"a\"")
            .replace("\"plant/", "\"a/")
            .lines()
            .map(|l| l.to_owned() + "\n")
            .collect()
    };
    promised(&said, &mut with).unwrap();
    promised(&of_a(text(&plain.stdout)), &mut without).unwrap();
    with.retain(|key, _| key.starts_with("a/"));
    assert_eq!(with, without);
}

#[test]
fn a_study_that_takes_too_long_is_ended_and_said_so() {
    let plant = Plant::new();
    let line = format!("{WATCH} --unit rig --diagnose 0.0556 --diagnose-limit 0.01");
    let mut child = plant.spawn(&line);
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(stream("a").as_bytes()).unwrap();
    stdin.flush().unwrap();
    let mut out = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    let failed = out.find(|line| line.contains("gap-study-failed")).unwrap();
    assert!(failed.contains("it took longer than 0.01 s"), "{failed}");
    drop(stdin);
    child.wait().unwrap();
}
