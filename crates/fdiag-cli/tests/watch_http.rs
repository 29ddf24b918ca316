//! The live page, `/metrics` and `/healthz` of a monitor that runs.
#![cfg(feature = "http")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

mod watching;

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
};

use watching::Plant;

/// Asks for a path; the answer as far as it is sent at once.
fn get(address: &str, path: &str) -> (TcpStream, u16) {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
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
    let line = "watch --model model.toml --spec spec.toml --healthy healthy.csv --unit rig \
                --http 127.0.0.1:0 --state state";
    let mut child = plant.spawn(line);
    let mut said = String::new();
    BufReader::new(child.stderr.take().unwrap()).read_line(&mut said).unwrap();
    let address = said.trim().strip_prefix("live page: http://").unwrap().trim_end_matches('/');

    // A page that was open before the samples came is told of the alarm.
    let (live, status) = get(address, "/live");
    assert_eq!(status, 200);
    let mut live = BufReader::new(live).lines().map(Result::unwrap);
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
