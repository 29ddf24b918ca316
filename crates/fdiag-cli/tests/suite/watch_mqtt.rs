//! A broker between plant and monitor: kills of either lose nothing and double nothing.
#![cfg(feature = "mqtt")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]
#![allow(clippy::print_stdout, reason = "figures")]

use std::{
    collections::BTreeMap,
    process::Command,
    time::{Duration, Instant},
};

use crate::watching::broker::{Broker, Heard, wait};
use crate::watching::ears::{Ears, messages, union};
use crate::watching::{Plant, text, week};
use fd_watch::Message;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const WATCH: &str = "watch --model model.toml --spec spec.toml --healthy healthy.csv --unit rig";

fn message(line: &str) -> Message {
    serde_json::from_str(line).unwrap()
}

/// A broker, somebody who listens to alarms, and the command of a monitor between them whose session has begun.
struct Trial<'a> {
    plant: &'a Plant,
    broker: Broker,
    heard: Heard,
    line: String,
    random: Xoshiro256PlusPlus,
    /// What each monitor has said.
    texts: Vec<String>,
    kills: u32,
    broken: u32,
}

impl<'a> Trial<'a> {
    fn begin(plant: &'a Plant, more: &str) -> Self {
        let broker = Broker::new();
        let heard = broker.listen("listener", "fdiag/#");
        let port = broker.port;
        let line = format!(
            "{WATCH} --state state {more} --mqtt 127.0.0.1:{port} --mqtt-in plant/+ --mqtt-out fdiag"
        );
        // The session begins before the first sample is sent: what was sent before is nobody's.
        let mut first = plant.spawn(&line);
        let out = Ears::on(&mut first);
        assert!(wait(Duration::from_secs(60), || out.said().contains("\"kind\":\"connected\"")));
        std::thread::sleep(Duration::from_millis(300));
        first.kill().unwrap();
        first.wait().unwrap();
        let random = Xoshiro256PlusPlus::seed_from_u64(7);
        Self { plant, broker, heard, line, random, texts: Vec::new(), kills: 0, broken: 0 }
    }

    /// A monitor that is killed after a random time, or asked to end; every fourth one loses its broker for a while.
    fn disturb(&mut self, longest: Duration) {
        let mut child = self.plant.spawn(&self.line);
        let out = Ears::on(&mut child);
        let milliseconds = u64::try_from(longest.as_millis()).unwrap();
        let random = &mut self.random;
        let mut pause =
            || std::thread::sleep(Duration::from_millis(random.random_range(20..milliseconds)));
        pause();
        if self.kills % 4 == 3 {
            self.broker.stop();
            pause();
            self.broken += 1;
            self.broker.start();
            pause();
        }
        if self.kills % 5 == 4 {
            Command::new("kill").arg(child.id().to_string()).status().unwrap();
        } else {
            child.kill().unwrap();
        }
        child.wait().unwrap();
        self.kills += 1;
        self.texts.push(out.said());
    }

    /// A last monitor that may finish; then both the monitors and the broker have said what is expected.
    fn end(&mut self, expected: &BTreeMap<String, String>, longest: Duration) {
        let mut last = self.plant.spawn(&self.line);
        let out = Ears::on(&mut last);
        let is_complete = || {
            let all: Vec<String> = self.texts.iter().cloned().chain([out.said()]).collect();
            let told = union(&[self.heard.lines("/alarm")]);
            (union(&all).len(), told.len()) == (expected.len(), expected.len())
        };
        // It may be complete before it has begun to listen, to signals too.
        assert!(wait(longest, || out.said().contains("\"kind\":\"connected\"")));
        wait(longest, is_complete);
        Command::new("kill").arg(last.id().to_string()).status().unwrap();
        assert!(last.wait().unwrap().success(), "it ends well when it is asked to");
        self.texts.push(out.said());
        assert_eq!(&union(&self.texts), expected);
        let told = self.heard.lines("/alarm");
        assert_eq!(&union(std::slice::from_ref(&told)), expected, "what the broker was told");
        let spoke = self.texts.iter().filter(|t| t.contains("\"type\":\"alarm\"")).count();
        let lines = self.texts.iter().flat_map(|text| text.lines());
        let again = lines.filter(|line| !line.starts_with(r#"{"type":"event""#)).count();
        println!(
            "{} ends of the monitor, {} restarts of the broker, {spoke} monitors had raised an alarm; {} messages, \
             {} said again, {} told to the broker again",
            self.kills,
            self.broken,
            expected.len(),
            again - expected.len(),
            told.lines().count() - expected.len()
        );
    }
}

/// `FDIAG_KILLS=100` with `--nocapture` gives the figures of `docs/results/watch.md`.
#[test]
#[ignore = "needs mosquitto"]
fn through_mosquitto_kills_of_monitor_and_broker_lose_and_double_nothing() {
    let kills = std::env::var("FDIAG_KILLS").map_or(10, |kills| kills.parse().unwrap());
    let (plant, stream) = (Plant::new(), Plant::stream(2000));
    let undisturbed = plant.run(WATCH, &stream);
    assert!(undisturbed.status.success(), "{}", text(&undisturbed.stderr));
    let expected = union(&[text(&undisturbed.stdout)]);
    assert!(30 <= expected.len(), "{} messages", expected.len());

    let mut trial = Trial::begin(&plant, "--save-every 0");
    let (mut publish, samples) = (trial.broker.publisher(), messages(&stream));
    let pause = Duration::from_millis(100) * kills / 30;
    let publisher = std::thread::spawn(move || {
        for piece in samples.chunks(100) {
            publish(piece);
            std::thread::sleep(pause);
        }
    });
    for _ in 0..kills {
        trial.disturb(Duration::from_millis(300));
    }
    publisher.join().unwrap();
    trial.end(&expected, Duration::from_secs(60));

    // Whoever comes late is told how each unit is, once.
    let late = trial.broker.listen("late", "fdiag/+/state");
    assert!(wait(Duration::from_secs(10), || late.by_topic().len() == 3));
    for (topic, states) in late.by_topic() {
        let unit = topic.split('/').nth(1).unwrap();
        let about = expected.values().map(|line| message(line)).filter(|m| m.unit() == Some(unit));
        let newest = about.max_by(|a, b| a.time().partial_cmp(&b.time()).unwrap()).unwrap();
        assert_eq!(states.len(), 1, "{topic}");
        assert!(states[0].contains(&newest.to_json()), "{topic}: {}", states[0]);
    }
}

/// A week of three plants with a sample every 10 s: drifts and steps, kills, a broker that goes away.
/// `--nocapture` gives the figures of `docs/results/watch.md`.
#[test]
#[ignore = "needs mosquitto"]
fn through_mosquitto_a_week_finds_every_fault_once() {
    let plant = Plant::new();
    let (stream, faults) = week::write(&plant);
    let begun = Instant::now();
    let undisturbed = plant.run(WATCH, &stream);
    assert!(undisturbed.status.success(), "{}", text(&undisturbed.stderr));
    let expected = union(&[text(&undisturbed.stdout)]);
    println!("undisturbed: {:.1} s", begun.elapsed().as_secs_f64());

    let begun = Instant::now();
    let mut trial = Trial::begin(&plant, "");
    let (publish, samples) = (trial.broker.publisher(), messages(&stream));
    let sent = samples.len();
    let publisher = std::thread::spawn(move || samples.chunks(500).for_each(publish));
    while !publisher.is_finished() {
        trial.disturb(Duration::from_secs(4));
    }
    publisher.join().unwrap();
    trial.end(&expected, Duration::from_secs(300));
    println!("{sent} samples, disturbed: {:.1} s", begun.elapsed().as_secs_f64());

    let alarms: Vec<(String, f64)> = expected
        .values()
        .filter_map(|line| match message(line) {
            Message::Alarm(alarm) => Some((alarm.unit, alarm.time)),
            _ => None,
        })
        .collect();
    let is_of = |fault: &week::Fault, (unit, time): &(String, f64)| {
        fault.unit == *unit && (fault.from..fault.to).contains(time)
    };
    let found = |fault: &week::Fault| alarms.iter().filter(|alarm| is_of(fault, alarm)).count();
    let counts: Vec<usize> = faults.iter().map(found).collect();
    let without =
        alarms.iter().filter(|alarm| !faults.iter().any(|fault| is_of(fault, alarm))).count();
    let once = counts.iter().filter(|count| **count == 1).count();
    println!("{} faults: {once} found once; {without} alarms without a fault", faults.len());
    assert_eq!((once, without), (faults.len(), 0), "{counts:?}");
}
