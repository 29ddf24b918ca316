//! The live page, `/metrics` and `/healthz` of a monitor that runs.
#![cfg(feature = "http")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]
#![allow(clippy::format_collect, reason = "a short stream")]

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
};

use crate::watching::Plant;

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

/// Posts an answer; status and body.
fn post(address: &str, kind: &str, body: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(
        stream,
        "POST /answer HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Type: {kind}\r\n\
         Content-Length: {}\r\n\r\n{body}",
        body.len()
    )
    .unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    let status = text.split(' ').nth(1).unwrap().parse().unwrap();
    (status, text.split("\r\n\r\n").nth(1).unwrap_or_default().to_owned())
}

/// The input leaves the trained range; whoever is asked confirms, and it is kept before it is acknowledged.
#[test]
fn whoever_is_asked_can_answer_on_the_page() {
    let plant = Plant::new();
    let more =
        "compensation.operating_point = { policy = { kind = \"retrain\" }, time_constant = 20 }\n";
    std::fs::write(plant.path("spec.toml"), more.to_owned() + crate::watching::SPEC).unwrap();
    let line = "watch --model model.toml --spec spec.toml --healthy healthy.csv --ask \
                --http 127.0.0.1:0 --state state --save-every 1000000";
    let mut child = plant.spawn(line);
    let mut said = String::new();
    BufReader::new(child.stderr.take().unwrap()).read_line(&mut said).unwrap();
    let address = said.trim().strip_prefix("live page: http://").unwrap().trim_end_matches('/');
    let mut out = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    let mut stdin = child.stdin.take().unwrap();
    for k in 0..400 {
        let u = if k < 200 { 0.0 } else { 10.0 };
        let time = 0.1 * f64::from(k);
        writeln!(stdin, "{{\"time\":{time},\"fuel\":{u},\"speed\":0,\"temperature\":0}}").unwrap();
    }
    stdin.flush().unwrap();
    let wanted = out.find(|line| line.contains("retraining-wanted")).unwrap();
    let id = wanted.split("\"id\":\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
    let confirm = format!("{{\"id\":\"{id}\",\"answer\":\"confirm\"}}");

    // A form on somebody else's page can post this much, and no more.
    assert_eq!(post(address, "text/plain", &confirm).0, 415);
    assert_eq!(post(address, "application/json", "{\"id\":1}").0, 400);
    assert_eq!(post(address, "application/json", "{\"id\":\"x\",\"answer\":\"confirm\"}").0, 409);
    assert_eq!(get(address, "/answer").1, 404);
    assert_eq!(post(address, "application/json", &confirm), (200, "kept\n".to_owned()));
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = std::fs::read_to_string(plant.path("state/units/plant.unit")).unwrap();
    assert!(kept.contains("\"wish\":null"), "the answer outlives a kill");

    let rest: String = (400..420)
        .map(|k| {
            format!(
                "{{\"time\":{},\"fuel\":10,\"speed\":0,\"temperature\":0}}\n",
                0.1 * f64::from(k)
            )
        })
        .collect();
    let again = crate::watching::text(&plant.run(line, &rest).stdout);
    assert!(again.contains("training-started"), "{again}");
}
