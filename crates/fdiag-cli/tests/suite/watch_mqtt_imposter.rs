//! A broker that is broken, or none: it is said, connected to again, and what it has at last is what counts.
#![cfg(feature = "mqtt")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{
    collections::VecDeque,
    fs,
    io::Write,
    net::TcpListener,
    process::{Child, Stdio},
    time::{Duration, Instant},
};

use crate::watching::ears::{Ears, messages, union};
use crate::watching::imposter::{Imposter, Misdeed, connack, packet, publish, shout};
use crate::watching::{Plant, text};

const WATCH: &str = "watch --model model.toml --spec spec.toml --healthy healthy.csv --unit rig";
const LONG: Duration = Duration::from_secs(60);

fn wait(longest: Duration, mut is_so: impl FnMut() -> bool) -> bool {
    let begun = Instant::now();
    while !is_so() {
        if longest < begun.elapsed() {
            return false;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    true
}

fn cut(bytes: impl Into<Vec<u8>>) -> Misdeed {
    Misdeed { bytes: bytes.into(), is_cut: true }
}

/// It is for the client to end the connection.
fn held(bytes: impl Into<Vec<u8>>) -> Misdeed {
    Misdeed { bytes: bytes.into(), is_cut: false }
}

/// As `held`, in a session that has begun.
fn within(bytes: impl Into<Vec<u8>>) -> Misdeed {
    held([connack(1), bytes.into()].concat())
}

/// Largest memory that a program has had, in MB.
fn peak(child: &Child) -> f64 {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = kilobytes.and_then(|rest| rest.split_whitespace().next());
    number.and_then(|number| number.parse::<f64>().ok()).map_or(0.0, |kb| kb / 1024.0)
}

/// A monitor between misdeeds, after which it has to have everything; the events of the connection of its samples.
fn endured(of_samples: &[Misdeed], of_alarms: &[Misdeed]) -> Vec<String> {
    let (plant, stream) = (Plant::new(), Plant::stream(250));
    let undisturbed = plant.run(WATCH, &stream);
    let expected = union(&[text(&undisturbed.stdout)]);
    assert!(3 < expected.len(), "{expected:?}");

    let samples = VecDeque::from(messages(&stream));
    let broker = Imposter::new(of_samples.to_vec(), of_alarms.to_vec(), samples, 1);
    let post = || broker.post.lock().unwrap();
    let port = broker.port;
    let mut monitor = plant.spawn(&format!(
        "{WATCH} --state state --mqtt 127.0.0.1:{port} --mqtt-in plant/+ --mqtt-out fdiag"
    ));
    let out = Ears::on(&mut monitor);
    let told = || {
        let heard = post().heard.clone();
        let heard = heard.iter().filter(|(topic, _)| topic.ends_with("/alarm"));
        union(&[heard
            .flat_map(|(_, texts)| texts)
            .flat_map(|text| [text.as_str(), "\n"])
            .collect()])
    };
    let is_done = || post().waiting.is_empty() && told().len() == expected.len();
    assert!(wait(LONG, is_done), "{} wait; {}", post().waiting.len(), out.said());
    let peak = peak(&monitor);
    std::process::Command::new("kill").arg(monitor.id().to_string()).status().unwrap();
    let output = monitor.wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert_eq!(union(&[out.said()]), expected);
    assert_eq!(told(), expected);
    assert_eq!(post().patient, 0, "connections that it should have ended");
    assert!(!text(&output.stderr).contains("panic"), "{}", text(&output.stderr));
    let of_broker = |line: &&str| line.contains("connected\"");
    assert!(peak < 100.0, "{peak} MB");
    out.said().lines().filter(of_broker).map(str::to_owned).collect()
}

/// Each misdeed within a session is an event with a reason of these words; then comes that of the cut.
fn each_is_said(misdeeds: &[(Misdeed, &str)]) {
    let all: Vec<Misdeed> = misdeeds.iter().map(|(misdeed, _)| misdeed.clone()).collect();
    let reasons = reasons(&endured(&all, &[]));
    assert_eq!(reasons.len(), misdeeds.len() + 1, "{reasons:#?}");
    for (reason, (_, words)) in reasons.iter().zip(misdeeds) {
        assert!(reason.contains(words), "{words}: {reason}");
    }
}

/// Why connections ended, in order.
fn reasons(events: &[String]) -> Vec<String> {
    let gone = events.iter().filter(|line| line.contains("\"disconnected\""));
    gone.map(|line| line.split("\"reason\":").nth(1).unwrap().to_owned()).collect()
}

#[test]
fn what_is_no_broker_is_said_once_and_tried_again() {
    let misdeeds = [
        cut(""),
        cut("HTTP/1.1 400 Bad Request\r\n\r\n"),
        // Half an answer; one that refuses; one that nobody knows; something else.
        cut([0x20, 2, 1]),
        held([0x20, 2, 0, 5]),
        held([0x20, 2, 0, 9]),
        held(shout("plant/u0", b"{}")),
    ];
    let events = endured(&misdeeds, &[]);
    let reasons = reasons(&events);
    // Once for all of these, and once for the cut in the midst of a message.
    assert!(events[0].contains("\"disconnected\""), "{events:#?}");
    assert!(reasons.len() == 2 && reasons[0].contains("Connection closed"), "{reasons:#?}");
}

#[test]
fn packets_that_are_none_end_the_connection() {
    // A length without an end; a giant that is cut off.
    let endless = within([0x30, 0xff, 0xff, 0xff, 0xff, 0xff]);
    let giant = cut([connack(1), vec![0x30, 0xff, 0xff, 0xff, 0x7f], vec![0; 1 << 20]].concat());
    let begun = Instant::now();
    each_is_said(&[
        (endless, "Malformed remaining length"),
        (giant, ""),
        (within(packet(0x30, &[&[0xff, 0xff], b"plant"])), "boundary crossed"),
        (within(packet(0x30, &[&[0, 2, 0xc3, 0x28], b"{}"])), "not UTF-8"),
        (within(publish(0, "plant/u0", "{}")), "id Zero"),
        (within(packet(0x36, &[&[0, 1], b"a", &[0, 1], b"{}"])), "QoS level: 3"),
        (within([0xf0, 0]), "packet type: 15"),
    ]);
    // Connections that do not last are made less and less often: 0.1 s, 0.2 s, ..., 5 s.
    assert!(Duration::from_secs(10) < begun.elapsed(), "{:?}", begun.elapsed());
}

#[test]
fn packets_out_of_place_end_the_connection() {
    each_is_said(&[
        // Receipts for what was never sent, of either quality of service.
        (within(packet(0x40, &[&[0, 17]])), "unsolicited ack pkid: 17"),
        (within(packet(0x50, &[&[0, 17]])), "unsolicited ack pkid: 17"),
        (within(packet(0x62, &[&[0, 17]])), "unsolicited ack pkid: 17"),
        (within(packet(0x70, &[&[0xff, 0xff]])), "unsolicited ack pkid: 65535"),
        // A second beginning; what only clients send.
        (within(connack(1)), "wrong packet"),
        (within(packet(0x82, &[&[0, 1, 0, 1], b"#", &[1]])), "wrong packet"),
    ]);
}

#[test]
fn alarms_that_nobody_has_confirmed_are_told_again() {
    let receipts: Vec<u8> = (1..=50).flat_map(|n| packet(0x40, &[&[0, n]])).collect();
    let begun = connack(0);
    let misdeeds = [
        held([begun.clone(), receipts].concat()),
        cut([begun.clone(), packet(0x40, &[&[0, 1]])].concat()),
        cut(begun),
    ];
    let events = endured(&[], &misdeeds);
    assert_eq!(reasons(&events).len(), 1, "that of the samples is cut once: {events:#?}");
}

/// Messages of megabytes, as many as the line takes, wait at the broker and not in the memory of the monitor; and of
/// lines that are no samples nothing is kept that was said.
#[test]
fn a_flood_waits_at_the_broker() {
    let plant = Plant::new();
    let broker = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = broker.local_addr().unwrap().port();
    let mut monitor = plant
        .command(&format!("{WATCH} --state state --mqtt 127.0.0.1:{port} --mqtt-in plant/+"))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let (mut stream, _) = broker.accept().unwrap();
    stream.write_all(&connack(1)).unwrap();
    // Half a million events; then 60 MB. A broker answers when it is asked whether it is there.
    stream.write_all(&shout("plant/u0", "{}\n".repeat(1 << 19).as_bytes())).unwrap();
    let lines = "               \n".repeat(1 << 18);
    let blank = [shout("plant/u0", lines.as_bytes()), vec![0xd0, 0]].concat();
    for _ in 0..15 {
        stream.write_all(&blank).unwrap();
    }
    // 8 MB wait, one is read and one is judged; else it would be all, and all events.
    let peak = peak(&monitor);
    assert!(0.0 < peak && peak < 70.0, "{peak} MB");
    monitor.kill().unwrap();
    monitor.wait().unwrap();
}
