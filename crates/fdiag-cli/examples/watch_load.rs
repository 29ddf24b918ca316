//! Load on `fdiag watch`: the figures of `docs/results/watch.md`.
//!
//! ```sh
//! cargo build --release -p fdiag-cli --bin fdiag --example watch_load
//! target/release/examples/watch_load latency 10000 10 60     # units, Hz, s: from a sample to its alarm
//! target/release/examples/watch_load soak 100 1000000000     # units, samples: as fast as they are taken
//! ```
//!
//! A fault of 5 s comes every 300 s to each unit; it has to be found once, and nothing else.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a program that measures, or fails")]

use std::{
    collections::HashMap,
    fs,
    io::{BufRead, BufReader, BufWriter, Write},
    path::Path,
    process::{Child, Command, Stdio},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const MODEL: &str = r#"
version = 1
kind = "state-space"
sample_time = 0.1
inputs = [{ name = "fuel", unit = "kg/s" }]
outputs = [{ name = "speed", unit = "rpm" }, { name = "temperature", unit = "K" }]
matrices = { A = [[0.90, 0.06], [-0.04, 0.83]], B = [[0.06], [0.11]], C = [[1.0, 0.0], [0.3, 1.0]], D = [[0.0], [0.0]] }
"#;
const SPEC: &str = r#"
hold_missing = 3
bias.orders = { kind = "fixed", na = 2, nb = 3 }
detector = { kind = "maximum", margin = 0.5 }
rule = { raise = 3, out_of = 3, clear = 5 }
isolation = { kind = "nearest", faults = "sensors" }
"#;
/// Samples after which the signals of a unit begin anew, where they ended.
const PERIOD: usize = 3000;
/// Samples of a fault, at the middle of a period.
const FAULT: usize = 50;
/// Samples that a unit is behind the one before it in the period.
const APART: usize = 29;

/// Inputs and outputs of a plant that is not quite the model, in the second of two equal periods.
fn period(seed: u64) -> Vec<[f64; 3]> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut u = 0.0;
    let inputs: Vec<f64> = (0..PERIOD)
        .map(|k| {
            if k % 15 == 0 {
                u = random.random_range(-1.0..1.0);
            }
            u
        })
        .collect();
    let mut x = [0.0, 0.0];
    let mut rows = Vec::new();
    for u in inputs.iter().chain(&inputs) {
        let noise = [random.random_range(-1e-3..1e-3), random.random_range(-1e-3..1e-3)];
        rows.push([*u, x[0] + noise[0], 0.3 * x[0] + x[1] + noise[1]]);
        x = [0.88 * x[0] + 0.07 * x[1] + 0.065 * u, -0.05 * x[0] + 0.83 * x[1] + 0.115 * u];
    }
    rows.split_off(PERIOD)
}

/// The lines of a unit without their beginning.
fn bodies() -> Vec<String> {
    let is_faulty = |k: usize| (PERIOD / 2..PERIOD / 2 + FAULT).contains(&k);
    let body = |(k, [u, speed, temperature]): (usize, [f64; 3])| {
        let temperature = if is_faulty(k) { temperature + 0.1 } else { temperature };
        format!(",\"fuel\":{u:.4},\"speed\":{speed:.5},\"temperature\":{temperature:.5}}}\n")
    };
    period(2).into_iter().enumerate().map(body).collect()
}

fn line(out: &mut impl Write, bodies: &[String], unit: usize, k: u64) -> std::io::Result<()> {
    let at = (usize::try_from(k).unwrap() + unit * APART) % PERIOD;
    write!(out, "{{\"rig\":\"u{unit}\",\"time\":{}.{}{}", k / 10, k % 10, bodies[at])
}

fn start(folder: &Path) -> Child {
    fs::write(folder.join("model.toml"), MODEL).unwrap();
    fs::write(folder.join("spec.toml"), SPEC).unwrap();
    let mut log = b"time,fuel,speed,temperature\n".to_vec();
    for (k, [u, speed, temperature]) in period(1).into_iter().enumerate() {
        writeln!(log, "{:.1},{u:.4},{speed:.5},{temperature:.5}", k as f64 / 10.0).unwrap();
    }
    fs::write(folder.join("healthy.csv"), log).unwrap();
    let own = std::env::current_exe().unwrap();
    let program = own.parent().unwrap().parent().unwrap().join("fdiag");
    Command::new(program)
        .args("watch --model model.toml --spec spec.toml --healthy healthy.csv --unit rig --state state".split(' '))
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

/// What a program has needed so far.
struct Cost {
    /// Memory in MB: now, and the most.
    memory: [f64; 2],
    /// CPU time in s.
    cpu: f64,
}

/// As `/proc/PID` says.
fn cost(child: &Child) -> Cost {
    let read =
        |file: &str| fs::read_to_string(format!("/proc/{}/{file}", child.id())).unwrap_or_default();
    let status = read("status");
    let kilobytes = |key: &str| {
        let rest = status.lines().find_map(|line| line.strip_prefix(key))?;
        rest.trim().strip_suffix(" kB")?.trim().parse::<f64>().ok()
    };
    let memory = ["VmRSS:", "VmHWM:"].map(|key| kilobytes(key).unwrap_or(f64::NAN) / 1024.0);
    let stat = read("stat");
    let ticks = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    let cpu: f64 = ticks.skip(11).take(2).filter_map(|t| t.parse::<f64>().ok()).sum();
    // Linux counts in hundredths of a second.
    Cost { memory, cpu: cpu / 100.0 }
}

/// Unit and time in samples of an alarm, and when it was read.
type Heard = Vec<(usize, u64, Instant)>;

/// Listens to the end; `alarms` counts them meanwhile.
fn listen(child: &mut Child, alarms: &Arc<AtomicU64>) -> std::thread::JoinHandle<(Heard, u64)> {
    let alarms = Arc::clone(alarms);
    let out = BufReader::new(child.stdout.take().unwrap());
    std::thread::spawn(move || {
        let (mut heard, mut events) = (Vec::new(), 0);
        for line in out.lines().map(Result::unwrap) {
            let now = Instant::now();
            let message: serde_json::Value = serde_json::from_str(&line).unwrap();
            match message["type"].as_str() {
                Some("alarm") => {
                    let unit = message["unit"].as_str().unwrap()[1..].parse().unwrap();
                    let k = (message["time"].as_f64().unwrap() * 10.0).round();
                    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                    heard.push((unit, k as u64, now));
                    alarms.fetch_add(1, Ordering::Relaxed);
                }
                Some("event") => {
                    events += 1;
                    println!("{line}");
                }
                _ => {}
            }
        }
        (heard, events)
    })
}

/// Compares what was found with what was there: faults that were found once, never, more than once, and alarms without.
fn compare(heard: &Heard, units: usize, samples: u64) -> [usize; 4] {
    let mut found: HashMap<(usize, u64), usize> = HashMap::new();
    let mut without = 0;
    for (unit, k, _) in heard {
        let at = k + (unit * APART) as u64;
        // A fault is found within it.
        let since = (at % PERIOD as u64).checked_sub((PERIOD / 2) as u64);
        if since.is_some_and(|since| since < FAULT as u64) {
            *found.entry((*unit, at / PERIOD as u64)).or_default() += 1;
        } else {
            without += 1;
        }
    }
    let mut all = 0;
    for unit in 0..units {
        let shift = (unit * APART) as u64;
        let start = |n: u64| n * PERIOD as u64 + (PERIOD / 2) as u64;
        // Those that began and lasted at least ten samples within the stream, which begins settled after 100.
        all += (0..=(samples + shift) / PERIOD as u64)
            .filter(|n| shift + 100 <= start(*n) && start(*n) + 10 <= samples + shift)
            .count();
    }
    let once = found.values().filter(|times| **times == 1).count();
    [once, all.saturating_sub(found.len()), found.len() - once, without]
}

fn latency(units: usize, hertz: u64, seconds: u64) {
    let folder = tempfile::tempdir().unwrap();
    let (mut child, bodies) = (start(folder.path()), bodies());
    let heard = listen(&mut child, &Arc::default());
    let mut stdin = BufWriter::with_capacity(1 << 16, child.stdin.take().unwrap());
    let (tick, burst) =
        (Duration::from_secs(1) / u32::try_from(hertz).unwrap(), units.div_ceil(100));
    // Training comes first.
    std::thread::sleep(Duration::from_secs(5));
    let begun = Instant::now();
    let due = |unit: usize, k: u64| {
        let share = (unit / burst) as f64 / (units.div_ceil(burst)) as f64;
        begun + tick * u32::try_from(k).unwrap() + tick.mul_f64(share)
    };
    for k in 0..seconds * hertz {
        for unit in 0..units {
            if unit % burst == 0 {
                stdin.flush().unwrap();
                std::thread::sleep(due(unit, k).saturating_duration_since(Instant::now()));
            }
            line(&mut stdin, &bodies, unit, k).unwrap();
        }
    }
    stdin.flush().unwrap();
    let late = begun.elapsed().as_secs_f64() - seconds as f64;
    std::thread::sleep(Duration::from_secs(1));
    let Cost { memory: [_, memory], cpu } = cost(&child);
    drop(stdin);
    child.wait().unwrap();
    let (heard, events) = heard.join().unwrap();
    // Making the diagnoses of all units is over after 10 s.
    let mut delays: Vec<f64> = heard
        .iter()
        .filter(|(_, k, _)| 10 * hertz <= *k)
        .map(|(unit, k, at)| at.saturating_duration_since(due(*unit, *k)).as_secs_f64() * 1e3)
        .collect();
    delays.sort_by(f64::total_cmp);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let quantile = |q: f64| {
        delays.get((q * (delays.len() as f64 - 1.0)) as usize).copied().unwrap_or(f64::NAN)
    };
    let [once, never, twice, without] = compare(&heard, units, seconds * hertz);
    println!(
        "{units} units at {hertz} Hz for {seconds} s: {} alarms, from sample to alarm p50 {:.1} ms, p90 {:.1} ms, \
         p99 {:.1} ms, most {:.1} ms; the source was {late:.2} s late at the end; {cpu:.1} s CPU, {memory:.0} MB; \
         found once {once}, never {never}, more than once {twice}, without a fault {without}; {events} events",
        delays.len(),
        quantile(0.5),
        quantile(0.9),
        quantile(0.99),
        quantile(1.0)
    );
}

fn soak(units: usize, samples: u64) {
    let folder = tempfile::tempdir().unwrap();
    let (mut child, bodies) = (start(folder.path()), bodies());
    let alarms = Arc::default();
    let heard = listen(&mut child, &alarms);
    let mut stdin = BufWriter::with_capacity(1 << 16, child.stdin.take().unwrap());
    let begun = Instant::now();
    let (each, mut told) = (samples / units as u64, Instant::now());
    for k in 0..each {
        for unit in 0..units {
            line(&mut stdin, &bodies, unit, k).unwrap();
        }
        if k % 1000 == 0 && Duration::from_secs(20) < told.elapsed() {
            told = Instant::now();
            let Cost { memory: [now, most], cpu } = cost(&child);
            println!(
                "{} samples, {:.0} s, {cpu:.0} s CPU, {now:.1} MB, at most {most:.1} MB, {} alarms",
                k * units as u64,
                begun.elapsed().as_secs_f64(),
                alarms.load(Ordering::Relaxed)
            );
            // A file that is there ends it early, and its figures are as good.
            if Path::new("stop-soak").exists() {
                return finish(child, stdin, heard, units, k + 1);
            }
        }
    }
    finish(child, stdin, heard, units, each);
}

fn finish(
    mut child: Child,
    stdin: impl Write,
    heard: std::thread::JoinHandle<(Heard, u64)>,
    units: usize,
    each: u64,
) {
    let Cost { memory: [_, memory], cpu } = cost(&child);
    drop(stdin);
    child.wait().unwrap();
    let (heard, events) = heard.join().unwrap();
    let [once, never, twice, without] = compare(&heard, units, each);
    println!(
        "{} samples of {units} units: {cpu:.0} s CPU, most memory {memory:.1} MB; found once {once}, never {never}, \
         more than once {twice}, without a fault {without}; {events} events",
        each * units as u64
    );
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize| args.get(i).and_then(|text| text.parse::<u64>().ok());
    match (args.first().map(String::as_str), number(1), number(2), number(3)) {
        (Some("latency"), Some(units), Some(hertz), Some(seconds)) => {
            latency(usize::try_from(units).unwrap(), hertz, seconds);
        }
        (Some("soak"), Some(units), Some(samples), None) => {
            soak(usize::try_from(units).unwrap(), samples);
        }
        _ => println!("watch_load latency UNITS HERTZ SECONDS | soak UNITS SAMPLES"),
    }
}
