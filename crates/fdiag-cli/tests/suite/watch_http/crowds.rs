//! Slow, many and silent clients: the monitor goes on, and whoever asks at once is answered.

use std::{
    io::{Read, Write},
    net::TcpStream,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use super::{body, get, live};
use crate::watching::Plant;

/// Most requests that wait at once, and most live pages.
const WAITING: usize = 64;
const VIEWERS: usize = 20;

fn status(pid: u32, what: &str) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix(&format!("{what}:"))).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

fn wait(mut is_so: impl FnMut() -> bool) -> bool {
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(90) {
        if is_so() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    false
}

#[test]
fn whoever_asks_at_once_is_answered_beside_200_who_do_not() {
    let plant = Plant::new();
    let (mut child, address) = live(&plant, "--unit rig --state state");
    let threads = status(child.id(), "Threads");
    let mut silent: Vec<TcpStream> = (0..200)
        .map(|number| {
            let mut stream = TcpStream::connect(&address).unwrap();
            // A head that trickles, one that promises a body, and nothing at all.
            let begun: &[u8] = match number % 3 {
                0 => b"GET / HTTP/1.1\r\nHost: localhost\r\nX-Long: ",
                1 => b"POST /answer HTTP/1.1\r\nHost: localhost\r\nContent-Length: 4000\r\n\r\n",
                _ => b"",
            };
            stream.write_all(begun).unwrap();
            stream
        })
        .collect();
    let asked = Instant::now();
    assert!(body(&address, "/metrics").contains("fdiag_watch_samples_total"));
    assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
    let most = threads + WAITING as u64 + 2;
    assert!(wait(|| status(child.id(), "Threads") <= most), "{}", status(child.id(), "Threads"));
    // They trickle on, and are sent away in time.
    let begun = Instant::now();
    let is_over = wait(|| {
        for stream in &mut silent {
            let _ = stream.write_all(b"a");
        }
        status(child.id(), "Threads") <= threads + 1
    });
    assert!(is_over, "{}", status(child.id(), "Threads"));
    assert!(begun.elapsed() < Duration::from_secs(15), "{:?}", begun.elapsed());

    // The monitor has not noticed.
    child.stdin.take().unwrap().write_all(Plant::stream(140).as_bytes()).unwrap();
    let out = child.wait_with_output().unwrap();
    assert!(out.status.success());
    assert!(String::from_utf8_lossy(&out.stdout).contains("\"type\":\"alarm\""));
}

#[test]
fn heads_and_bodies_without_end_are_refused() {
    let plant = Plant::new();
    let (mut child, address) = live(&plant, "");
    let memory = status(child.id(), "VmRSS");
    let mut stream = TcpStream::connect(&address).unwrap();
    let mut sent = 0;
    // The server says no long before this is over.
    while sent < 100_000_000 && stream.write_all(&[b'a'; 10_000]).is_ok() {
        sent += 10_000;
    }
    assert!(sent < 100_000_000, "100 MB of a head were taken");
    assert!(status(child.id(), "VmRSS") < memory + 10_000, "kB");

    let mut stream = TcpStream::connect(&address).unwrap();
    let long = format!("GET / HTTP/1.1\r\nHost: localhost\r\nX-Long: {}\r\n\r\n", "a".repeat(9000));
    stream.write_all(long.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 431 "), "{answer}");
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn event_streams_that_nobody_reads_end() {
    let plant = Plant::new();
    let (mut child, address) = live(&plant, "--unit rig --state state");
    let mut unread: Vec<TcpStream> = (0..VIEWERS).map(|_| get(&address, "/live").0).collect();
    assert_eq!(get(&address, "/live").1, 503, "one more");
    // Events, until there are more than the system keeps for whoever does not read.
    let mut out = child.stdout.take().unwrap();
    std::thread::spawn(move || std::io::copy(&mut out, &mut std::io::sink()));
    let mut stdin = child.stdin.take().unwrap();
    let is_enough = Arc::new(AtomicBool::new(false));
    let enough = Arc::clone(&is_enough);
    let feed = std::thread::spawn(move || {
        let lines = "no sample\n".repeat(100);
        while !enough.load(Ordering::Relaxed) {
            stdin.write_all(lines.as_bytes()).unwrap();
            std::thread::sleep(Duration::from_millis(2));
        }
    });
    let is_free = wait(|| get(&address, "/live").1 == 200);
    let most = status(child.id(), "VmHWM");
    is_enough.store(true, Ordering::Relaxed);
    feed.join().unwrap();
    assert!(is_free, "whoever does not read keeps the places");
    unread.clear();
    assert!(most < 300_000, "{most} kB");
    assert!(child.wait().unwrap().success());
}
