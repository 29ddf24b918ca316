//! `fdiag watch` as a user meets it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{
    collections::BTreeMap,
    fs,
    io::{BufRead, BufReader, Write},
    process::Command,
    time::Duration,
};

use crate::watching::{Plant, promised, text};

const WATCH: &str = "watch --model model.toml --spec spec.toml --healthy healthy.csv";

/// The keys of every kind of message, which `docs/watch.md` lists.
#[test]
fn messages_have_the_documented_shape() {
    let plant = Plant::new();
    let output = plant.run(&format!("{WATCH} --unit rig"), &Plant::stream(400));
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(output.stderr.is_empty(), "nobody is looking: {}", text(&output.stderr));
    let mut shapes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for line in text(&output.stdout).lines() {
        let message: serde_json::Map<String, serde_json::Value> =
            serde_json::from_str(line).unwrap();
        let name = |key: &str| message.get(key).and_then(|v| v.as_str()).unwrap_or("").to_owned();
        let keys = message.keys().cloned().collect();
        shapes.insert(format!("{} {}", name("type"), name("kind")).trim().to_owned(), keys);
    }
    let documented = fs::read_to_string("../../docs/watch.md").unwrap();
    for (kind, mut keys) in shapes.clone() {
        keys.sort();
        for key in keys {
            assert!(
                documented.contains(&format!("`{key}`")),
                "{kind}: {key} is not in docs/watch.md"
            );
        }
        let name = kind.rsplit(' ').next().unwrap();
        assert!(documented.contains(&format!("`{name}`")), "{name} is not in docs/watch.md");
    }
    let kinds: Vec<&str> = shapes.keys().map(String::as_str).collect();
    for kind in [
        "alarm",
        "update",
        "cleared",
        "event gap",
        "event bridged",
        "event doubled",
        "event late",
        "event clock-jumped",
    ] {
        assert!(kinds.contains(&kind), "{kind} did not occur: {kinds:?}");
    }
}

/// A CSV through a pipe, a file that is followed, and a file that is there say the same.
#[test]
fn a_followed_file_is_watched_as_a_stream_is() {
    let plant = Plant::new();
    let stream = Plant::stream(300);
    let line = format!("{WATCH} --unit rig");
    let mut expected = BTreeMap::new();
    promised(&text(&plant.run(&line, &stream).stdout), &mut expected).unwrap();
    assert!(!expected.is_empty());

    let path = plant.path("growing.ndjson");
    let middle = stream.len() / 2;
    fs::write(&path, &stream[..middle]).unwrap();
    let mut child = plant.spawn(&format!("{line} --state state --follow growing.ndjson"));
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut said = String::new();
    out.read_line(&mut said).unwrap();
    let mut file = fs::OpenOptions::new().append(true).open(&path).unwrap();
    file.write_all(&stream.as_bytes()[middle..]).unwrap();
    let mut found = BTreeMap::new();
    while found != expected {
        assert_ne!(out.read_line(&mut said).unwrap(), 0, "{said}");
        promised(&said, &mut found).unwrap();
    }
    // It is asked to stop: all units are saved, and it is done.
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
    assert!(child.wait().unwrap().success());
    assert_eq!(fs::read_dir(plant.path("state/units")).unwrap().count(), 3);
    // Started again on the same stream, it has nothing to say but that it has seen it.
    let again = plant.run(&format!("{line} --state state"), &stream);
    let again = text(&again.stdout);
    promised(&again, &mut BTreeMap::new()).unwrap();
    assert!(!again.contains(r#""type":"alarm""#), "{again}");
}

#[test]
fn wrong_requests_are_refused_with_a_reason() {
    let plant = Plant::new();
    let refused = |line: &str, stdin: &str, code: i32, words: &str| {
        let output = plant.run(line, stdin);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "`{line}`: {error}");
        assert!(error.contains(words), "`{line}`: {error}");
    };
    refused("watch --model model.toml", "", 2, "--healthy");
    refused("watch --model none.toml --learn 100", "", 3, "none.toml");
    refused(
        &format!("{WATCH} --format csv"),
        "t,fuell,speed,temperature\n",
        3,
        "did you mean `fuell`?",
    );
    refused("watch --model model.toml --learn 100000000", "", 4, "limit `samples`");
    refused(&format!("{WATCH} --sample-time 0.2"), "", 3, "sample time of");
    refused(&format!("{WATCH} --follow none.csv"), "", 3, "none.csv");
    fs::write(plant.path("file"), "").unwrap();
    refused(&format!("{WATCH} --state file"), "", 5, "file");
    // A monitor that runs keeps others away.
    let child = plant.spawn(&format!("{WATCH} --state state"));
    let lock = plant.path("state/state.json");
    while !lock.exists() {
        std::thread::sleep(Duration::from_millis(10));
    }
    refused(&format!("{WATCH} --state state"), "", 3, "another monitor runs on this state");
    child.wait_with_output().unwrap();
    refused(&format!("{WATCH} --state state --longest-gap 3"), "", 3, "made with another");
}

/// A second monitor on a state is refused before it has said or written anything, and the first does not notice.
#[test]
fn a_second_monitor_on_a_state_changes_nothing() {
    let plant = Plant::new();
    let stream = Plant::stream(600);
    let line = format!("{WATCH} --unit rig");
    let mut expected = BTreeMap::new();
    promised(&text(&plant.run(&line, &stream).stdout), &mut expected).unwrap();
    let line = format!("{line} --state state");
    let mut first = plant.spawn(&line);
    let mut stdin = first.stdin.take().unwrap();
    let (early, late) = stream.as_bytes().split_at(stream.len() / 2);
    stdin.write_all(early).unwrap();
    let journal = plant.path("state/journal.ndjson");
    while fs::metadata(&journal).map_or(0, |file| file.len()) == 0 {
        std::thread::sleep(Duration::from_millis(10));
    }
    for _ in 0..3 {
        let second = plant.run(&line, &stream);
        assert_eq!((second.status.code(), second.stdout.len()), (Some(3), 0));
        assert!(text(&second.stderr).contains("another monitor runs on this state"));
    }
    stdin.write_all(late).unwrap();
    drop(stdin);
    let first = first.wait_with_output().unwrap();
    assert!(first.status.success(), "{}", text(&first.stderr));
    let mut found = BTreeMap::new();
    promised(&text(&first.stdout), &mut found).unwrap();
    assert_eq!(found, expected);
    let mut kept = BTreeMap::new();
    promised(&fs::read_to_string(journal).unwrap(), &mut kept).unwrap();
    assert_eq!(kept, expected);
}

/// A disk that takes no more: what cannot be promised is not said, and comes when there is room.
#[cfg(unix)]
#[test]
fn a_full_disk_loses_no_alarm() {
    let plant = Plant::new();
    let stream = Plant::stream(600);
    let line = format!("{WATCH} --unit rig");
    let mut expected = BTreeMap::new();
    promised(&text(&plant.run(&line, &stream).stdout), &mut expected).unwrap();
    // No file may grow beyond 4 kB; the journal does.
    let binary = env!("CARGO_BIN_EXE_fdiag");
    let limited = format!("trap '' XFSZ; ulimit -f 4; exec {binary} {line} --state state");
    let mut command = Command::new("sh");
    command.args(["-c", &limited]).current_dir(plant.folder.path());
    command.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().unwrap();
    let _ = child.stdin.take().unwrap().write_all(stream.as_bytes());
    let full = child.wait_with_output().unwrap();
    assert_eq!(full.status.code(), Some(5), "{}", text(&full.stderr));
    assert!(text(&full.stderr).contains("cannot write state/"), "{}", text(&full.stderr));
    let mut found = BTreeMap::new();
    promised(&text(&full.stdout), &mut found).unwrap();
    assert!(found.len() < expected.len());
    let rest = plant.run(&format!("{line} --state state"), &stream);
    assert!(rest.status.success(), "{}", text(&rest.stderr));
    promised(&text(&rest.stdout), &mut found).unwrap();
    assert_eq!(found, expected);
}

/// Every example of the help text runs, but for the one that needs a broker: its right side does.
#[test]
fn the_examples_of_the_help_text_run() {
    let plant = Plant::new();
    let help = text(&plant.run("watch --help", "").stdout);
    let examples: Vec<&str> = help
        .lines()
        .filter_map(|line| line.split_once("fdiag watch ").map(|(_, rest)| rest))
        .filter(|rest| rest.contains("--model model.toml"))
        .collect();
    assert_eq!(examples.len(), 4, "{help}");
    let csv = "t,fuel,speed,temperature\n0,0,0,0\n0.1,0,0,0\n";
    for name in ["later.csv", "growing.csv"] {
        fs::write(plant.path(name), csv).unwrap();
    }
    for example in examples {
        let _ = fs::remove_dir_all(plant.path("state"));
        let line = example.split(" < ").next().unwrap();
        let stdin = if line.contains("--format csv") { csv.to_owned() } else { Plant::stream(20) };
        let output = if line.contains("--follow") {
            let child = plant.spawn(&format!("watch {line} --state state"));
            while !plant.path("state/journal.ndjson").exists() {
                std::thread::sleep(Duration::from_millis(10));
            }
            let id = child.id().to_string();
            // Once the journal is there, signals are heard soon; before, the state is as it was.
            std::thread::sleep(Duration::from_millis(200));
            Command::new("kill").args(["-TERM", &id]).status().unwrap();
            child.wait_with_output().unwrap()
        } else {
            plant.run(&format!("watch {line}"), &stdin)
        };
        assert!(output.status.success(), "{example}: {}", text(&output.stderr));
    }
}
