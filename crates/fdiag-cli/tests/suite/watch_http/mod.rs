//! The live page, `/metrics` and `/healthz` of a monitor that runs.
#![cfg(feature = "http")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]
#![allow(clippy::format_collect, reason = "a short stream")]

mod crowds;
mod gate;
mod proxy;

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    process::Child,
};

use crate::watching::Plant;

/// A monitor with a live page, and where that is.
fn live(plant: &Plant, more: &str) -> (Child, String) {
    let line = format!(
        "watch --model model.toml --spec spec.toml --healthy healthy.csv --http 127.0.0.1:0 {more}"
    );
    let mut child = plant.spawn(&line);
    let mut said = String::new();
    let mut from = BufReader::new(child.stderr.take().unwrap());
    from.read_line(&mut said).unwrap();
    // Whatever else it has to say, it does not wait for a reader.
    std::thread::spawn(move || std::io::copy(&mut from, &mut std::io::sink()));
    let address = said.trim().strip_prefix("live page: http://").unwrap().trim_end_matches('/');
    (child, address.to_owned())
}

/// Asks for a path; the answer as far as it is sent at once.
fn get(address: &str, path: &str) -> (TcpStream, u16) {
    get_as(address, address, path)
}

/// The same under the name of a host.
fn get_as(address: &str, host: &str, path: &str) -> (TcpStream, u16) {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
    let mut head = String::new();
    // Byte by byte: what follows belongs to whoever reads on.
    let mut byte = [0];
    while !head.ends_with("\r\n\r\n") {
        stream.read_exact(&mut byte).unwrap();
        head.push(char::from(byte[0]));
    }
    let status = head.split(' ').nth(1).unwrap().parse().unwrap();
    (stream, status)
}

fn body(address: &str, path: &str) -> String {
    let (mut stream, status) = get(address, path);
    assert_eq!(status, 200, "{path}");
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    text
}

#[test]
fn whoever_looks_sees_how_it_goes() {
    let plant = Plant::new();
    let (mut child, address) = self::live(&plant, "--unit rig --state state");
    let address = address.as_str();

    // A page that was open before the samples came is told of the alarm.
    let (live, status) = get(address, "/live");
    assert_eq!(status, 200);
    let mut live = BufReader::new(live).lines().map(Result::unwrap);
    assert_eq!(live.next().unwrap(), "retry: 500");
    assert_eq!(live.next().unwrap(), "event: all");
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(Plant::stream(140).as_bytes()).unwrap();
    let alarm = live.find(|line| line.starts_with("data: {\"type\":\"alarm\"")).unwrap();
    assert!(alarm.contains("\"unit\":\"u"), "{alarm}");
    let look = live.find(|line| line.contains("\"doing\":\"alarmed\"")).unwrap();
    assert!(look.contains("\"units\":[0,"), "{look}");

    let metrics = body(address, "/metrics");
    let value = |name: &str| -> f64 {
        let line = metrics.lines().find(|line| line.starts_with(&format!("fdiag_watch_{name} ")));
        line.unwrap_or_else(|| panic!("{name}: {metrics}"))
            .split(' ')
            .nth(1)
            .unwrap()
            .parse()
            .unwrap()
    };
    assert!(400.0 < value("samples_total") && 1.0 <= value("alarms_total"));
    assert!(value("dropped_total") + value("refused_total") < 1.0, "of a stream that is well");
    assert!(0.0 <= value("lag_seconds") && 0.0 <= value("last_sample_age_seconds"));
    // The format asks for help and type before every family.
    for line in metrics.lines().filter(|line| !line.starts_with('#')) {
        let name = line.split(['{', ' ']).next().unwrap();
        assert!(metrics.contains(&format!("# TYPE {name} ")), "{line}");
    }
    assert!(body(address, "/healthz").contains("\"cannot_save\":false"));
    assert!(body(address, "/").contains("EventSource(\"/live\")"));
    assert_eq!(get(address, "/nothing").1, 404);

    drop(stdin);
    assert!(child.wait().unwrap().success());
}

/// Posts an answer with these header fields; status and body.
fn post(address: &str, fields: &str, body: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(
        stream,
        "POST /answer HTTP/1.1\r\nConnection: close\r\n{fields}\r\nContent-Length: {}\r\n\r\n{body}",
        body.len()
    )
    .unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    let status = text.split(' ').nth(1).unwrap().parse().unwrap();
    (status, text.split("\r\n\r\n").nth(1).unwrap_or_default().to_owned())
}

/// A spec of units that are trained again, and samples whose input leaves the trained range.
const AGAIN: &str =
    "compensation.operating_point = { policy = { kind = \"retrain\" }, time_constant = 20 }\n";

fn leaving(samples: std::ops::Range<u32>) -> String {
    samples
        .map(|k| {
            let (time, u) = (0.1 * f64::from(k), if k < 200 { 0.0 } else { 10.0 });
            format!("{{\"time\":{time},\"fuel\":{u},\"speed\":0,\"temperature\":0}}\n")
        })
        .collect()
}

/// A monitor that asks whether to train again, where, and what it asks.
pub(crate) fn asking(plant: &Plant, more: &str) -> (Child, String, String) {
    std::fs::write(plant.path("spec.toml"), AGAIN.to_owned() + crate::watching::SPEC).unwrap();
    let (mut child, address) = live(plant, &format!("--ask {more}"));
    let mut out = BufReader::new(child.stdout.take().unwrap());
    child.stdin.as_mut().unwrap().write_all(leaving(0..400).as_bytes()).unwrap();
    let mut line = String::new();
    while !line.contains("retraining-wanted") {
        line.clear();
        assert_ne!(out.read_line(&mut line).unwrap(), 0, "nothing is asked");
    }
    std::thread::spawn(move || std::io::copy(&mut out, &mut std::io::sink()));
    let id = line.split("\"id\":\"").nth(1).unwrap().split('"').next().unwrap();
    (child, address, id.to_owned())
}

/// The token that the page carries.
fn token(page: &str) -> String {
    let rest = page.split("name=\"token\" content=\"").nth(1).unwrap();
    rest.split('"').next().unwrap().to_owned()
}
