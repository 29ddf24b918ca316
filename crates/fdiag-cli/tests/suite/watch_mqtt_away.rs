//! A broker that is away for an hour of the plant, and a disk that is full while it delivers: what waited comes late,
//! and nothing is lost.
#![cfg(feature = "mqtt")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]
#![allow(clippy::print_stdout, reason = "figures")]

use std::{
    collections::{BTreeMap, BTreeSet, HashSet},
    fs,
    io::Write,
    process::{Child, Command},
    time::{Duration, Instant},
};

use crate::watching::broker::{Broker, wait};
use crate::watching::ears::{Ears, messages, union};
use crate::watching::{Plant, text};

const WATCH: &str = "watch --model model.toml --spec spec.toml --healthy healthy.csv --unit rig";
/// Samples of each unit, at 10 Hz: half a minute, an hour without the broker, a minute.
const SAMPLES: [usize; 3] = [300, 36_000, 600];
const LONG: Duration = Duration::from_secs(120);

/// Seconds of the clock for a second of the plant: 0 without `FDIAG_PACE`, 1 for an hour that lasts an hour.
fn pace() -> f64 {
    std::env::var("FDIAG_PACE").map_or(0.0, |pace| pace.parse().unwrap())
}

/// The stream in three pieces, by lines.
fn pieces() -> [Vec<String>; 3] {
    let all: usize = SAMPLES.iter().sum();
    let lines: Vec<String> = Plant::stream(all).lines().map(|line| format!("{line}\n")).collect();
    let until = |samples: usize| lines.len() * samples / all;
    let (a, b) = (until(SAMPLES[0]), until(SAMPLES[0] + SAMPLES[1]));
    [lines[..a].to_vec(), lines[a..b].to_vec(), lines[b..].to_vec()]
}

/// What an undisturbed monitor promises of a stream, and the holes that it finds.
fn undisturbed(plant: &Plant, stream: &str) -> (BTreeMap<String, String>, BTreeSet<String>) {
    let output = plant.run(WATCH, stream);
    assert!(output.status.success(), "{}", text(&output.stderr));
    (union(&[text(&output.stdout)]), holes(&text(&output.stdout)))
}

fn holes(said: &str) -> BTreeSet<String> {
    said.lines().filter(|line| line.contains("\"kind\":\"gap\"")).map(str::to_owned).collect()
}

/// Gives lines of the hour to `take` when the plant has measured them, those of ten seconds together.
fn at_pace(lines: &[String], mut take: impl FnMut(&[String])) {
    // Three units at 10 Hz.
    let (begun, lasts) = (Instant::now(), pace() * lines.len() as f64 / 30.0);
    for (i, some) in lines.chunks(300).enumerate() {
        let due = Duration::from_secs_f64(
            lasts * (300 * (i + 1)).min(lines.len()) as f64 / lines.len() as f64,
        );
        std::thread::sleep(due.saturating_sub(begun.elapsed()));
        take(some);
    }
}

fn end(mut child: Child) {
    Command::new("kill").arg(child.id().to_string()).status().unwrap();
    assert!(child.wait().unwrap().success(), "it ends well when it is asked to");
}

/// Memory of a program, in MB.
fn memory(child: &Child) -> f64 {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let number = kilobytes.and_then(|rest| rest.split_whitespace().next());
    number.and_then(|number| number.parse::<f64>().ok()).map_or(f64::NAN, |kb| kb / 1024.0)
}

/// Samples come over a pipe; alarms are raised while nobody can be told, by two monitors, since one is killed.
#[test]
#[ignore = "needs mosquitto"]
fn through_mosquitto_alarms_of_an_hour_without_it_are_told_afterwards() {
    let (plant, [before, hour, after]) = (Plant::new(), pieces());
    let until_then = [before.concat(), hour.concat()].concat();
    let (expected, _) = undisturbed(&plant, &[until_then.clone(), after.concat()].concat());
    let (of_then, _) = undisturbed(&plant, &until_then);

    let mut broker = Broker::new();
    let heard = broker.listen("listener", "fdiag/#");
    let told = || union(&[heard.lines("/alarm")]);
    let line = format!("{WATCH} --state state --mqtt 127.0.0.1:{} --mqtt-out fdiag", broker.port);
    let mut first = plant.spawn(&line);
    let out = Ears::on(&mut first);
    let mut stdin = first.stdin.take().unwrap();
    stdin.write_all(before.concat().as_bytes()).unwrap();
    let is_told = || {
        let all = union(&[out.said()]);
        !all.is_empty() && all == told()
    };
    assert!(wait(LONG, is_told), "{:?}", told());
    let (at_first, memory_before) = (told().len(), memory(&first));

    broker.stop();
    let (begun, (early, late)) = (Instant::now(), hour.split_at(hour.len() / 2));
    let mut seen = before.concat();
    at_pace(early, |lines| {
        stdin.write_all(lines.concat().as_bytes()).unwrap();
        seen.push_str(&lines.concat());
    });
    first.kill().unwrap();
    first.wait().unwrap();
    let mut second = plant.spawn(&line);
    let out_again = Ears::on(&mut second);
    let mut stdin = second.stdin.take().unwrap();
    // Its source begins anew.
    stdin.write_all(seen.as_bytes()).unwrap();
    at_pace(late, |lines| stdin.write_all(lines.concat().as_bytes()).unwrap());
    let all = || union(&[out.said(), out_again.said()]);
    assert!(wait(LONG, || all().len() == of_then.len()));
    assert_eq!(all(), of_then, "it goes on without the broker");
    let journal = || fs::read_to_string(plant.path("state/journal.ndjson")).unwrap();
    assert_eq!(union(&[journal()]), of_then, "and keeps what it says");
    let (at_last, memory_after) = (told().len(), memory(&second));
    assert_eq!(at_last, at_first, "nobody heard of it");

    broker.start();
    let away = begun.elapsed();
    let begun = Instant::now();
    assert!(wait(LONG, || told().len() == of_then.len()), "{} of {}", told().len(), of_then.len());
    let caught_up = begun.elapsed();
    stdin.write_all(after.concat().as_bytes()).unwrap();
    assert!(wait(LONG, || told().len() == expected.len()));
    end(second);
    assert_eq!(told(), expected);
    assert_eq!(all(), expected);
    for (topic, texts) in heard.by_topic() {
        let Some(unit) = topic.strip_suffix("/alarm").and_then(|t| t.strip_prefix("fdiag/")) else {
            continue;
        };
        // In the order of the journal, which says each once; what was not confirmed may come twice.
        let mut known = HashSet::new();
        let heard: Vec<&str> =
            texts.iter().map(String::as_str).filter(|text| known.insert(*text)).collect();
        let (journal, about) = (journal(), format!("\"unit\":\"{unit}\""));
        let kept: Vec<&str> = journal.lines().filter(|line| line.contains(&about)).collect();
        assert_eq!(heard, kept, "{topic}");
    }
    let again = heard.lines("/alarm").lines().count() - expected.len();
    println!(
        "broker away for {:.1} s, in which {} messages were promised and waited in the journal ({} kB); the monitor had \
         {memory_before:.1} MB before and {memory_after:.1} MB after it; told within {:.2} s of its return; {} messages \
         in all, {again} told again, none lost or changed",
        away.as_secs_f64(),
        of_then.len() - at_last,
        journal().len() / 1000,
        caught_up.as_secs_f64(),
        expected.len(),
    );
}

/// Samples come from the broker: those of an hour wait at the source.
#[test]
#[ignore = "needs mosquitto"]
fn through_mosquitto_samples_of_an_hour_without_it_are_judged_afterwards() {
    let (plant, [before, hour, after]) = (Plant::new(), pieces());
    let (expected, expected_holes) =
        undisturbed(&plant, &[before.concat(), hour.concat(), after.concat()].concat());

    let mut broker = Broker::new();
    let heard = broker.listen("listener", "fdiag/#");
    let line = format!(
        "{WATCH} --state state --mqtt 127.0.0.1:{} --mqtt-in plant/+ --mqtt-out fdiag",
        broker.port
    );
    let mut monitor = plant.spawn(&line);
    let out = Ears::on(&mut monitor);
    assert!(wait(LONG, || out.said().contains("\"kind\":\"connected\"")));
    // The subscription follows at once.
    std::thread::sleep(Duration::from_millis(300));
    let (mut publish, mut publish_hour) = (broker.publisher(), broker.publisher());
    publish(&messages(&before.concat()));
    assert!(wait(LONG, || !union(&[out.said()]).is_empty()));

    broker.stop();
    let memory_before = memory(&monitor);
    let begun = Instant::now();
    let samples = hour.len();
    // What cannot be sent holds up what comes after it.
    let (waiting, came) = std::sync::mpsc::channel::<Vec<String>>();
    let source = std::thread::spawn(move || {
        for lines in came {
            publish_hour(&messages(&lines.concat()));
        }
    });
    at_pace(&hour, |lines| waiting.send(lines.to_vec()).unwrap());
    drop(waiting);
    std::thread::sleep(Duration::from_secs(2));
    assert!(!source.is_finished() && out.said().contains("\"kind\":\"disconnected\""));
    broker.start();
    let (away, memory_after) = (begun.elapsed(), memory(&monitor));
    let begun = Instant::now();
    source.join().unwrap();
    publish(&messages(&after.concat()));
    let told = || union(&[heard.lines("/alarm")]);
    wait(LONG, || told().len() == expected.len());
    assert_eq!(told(), expected);
    let caught_up = begun.elapsed();
    end(monitor);
    assert_eq!(union(&[out.said()]), expected);
    assert_eq!(holes(&out.said()), expected_holes, "no sample is missing");
    println!(
        "broker away for {:.1} s, in which {samples} samples waited at their source; the monitor had {memory_before:.1} MB \
         before and {memory_after:.1} MB after it; all judged and told within {:.1} s of its return; {} messages, none \
         lost or changed",
        away.as_secs_f64(),
        caught_up.as_secs_f64(),
        expected.len(),
    );
}

/// A disk that takes no more: the broker keeps the samples, and they come when there is room again.
#[test]
#[ignore = "needs mosquitto"]
fn through_mosquitto_a_full_disk_loses_no_sample() {
    let (plant, stream) = (Plant::new(), Plant::stream(600));
    let (expected, _) = undisturbed(&plant, &stream);
    let broker = Broker::new();
    let line = format!(
        "{WATCH} --state state --mqtt 127.0.0.1:{} --mqtt-in plant/+ --mqtt-out fdiag",
        broker.port
    );
    // No file may grow beyond a few kB, until somebody makes room.
    let limited =
        format!("trap '' XFSZ; ulimit -S -f 8; exec {} {line}", env!("CARGO_BIN_EXE_fdiag"));
    let mut command = Command::new("sh");
    command.args(["-c", &limited]).current_dir(plant.folder.path());
    command.stdin(std::process::Stdio::null()).stdout(std::process::Stdio::piped());
    let errors = plant.path("errors");
    command.stderr(fs::File::create(&errors).unwrap());
    let mut monitor = command.spawn().unwrap();
    let out = Ears::on(&mut monitor);
    assert!(wait(LONG, || out.said().contains("\"kind\":\"connected\"")));
    std::thread::sleep(Duration::from_millis(300));
    broker.publisher()(&messages(&stream));
    let says = |words: &str| fs::read_to_string(&errors).unwrap().contains(words);
    assert!(wait(LONG, || says("cannot write state/")), "{}", out.said());
    std::thread::sleep(Duration::from_secs(2));
    let early = union(&[out.said()]).len();
    assert!(early < expected.len(), "the disk was not full");
    assert!(monitor.try_wait().unwrap().is_none(), "{}", fs::read_to_string(&errors).unwrap());
    let room = ["--pid", &monitor.id().to_string(), "--fsize=unlimited"].map(str::to_owned);
    assert!(Command::new("prlimit").args(room).status().unwrap().success());
    wait(LONG, || union(&[out.said()]).len() == expected.len());
    end(monitor);
    assert_eq!(union(&[out.said()]), expected);
    println!("{early} of {} messages before there was room", expected.len());
}
