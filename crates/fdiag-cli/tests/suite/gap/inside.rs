//! Causes inside a model: where nothing around it explains the logs, and where one law inside explains them better.

use std::fmt::Write;

use crate::gap::{
    desk::{Desk, stdout},
    random::Random,
};

const MODEL: &str = r#"
version = 1
kind = "equations"
name = "vessels"
sample_time = 1.0

[parameters]
A1 = { unit = "m^2", value = 1.0, tolerance = 0.05 }
A2 = { unit = "m^2", value = 1.5, tolerance = 0.05 }
k1 = { unit = "m^2/s", value = 0.1, tolerance = 0.05 }
k2 = { unit = "m^2/s", value = 0.06, tolerance = 0.05 }

[inputs]
q = { unit = "m^3/s" }

[states]
h1 = { unit = "m", initial = 0.0, derivative = "(q - k1*h1)/A1" }
h2 = { unit = "m", initial = 0.0, derivative = "(k1*h1 - k2*h2)/A2" }

[outputs]
y = { unit = "m", value = "h2", noise = 0.005 }
"#;

/// Two vessels whose parameters are a little off, the pipe between which takes no more than `most` m^3/s.
fn log(most: f64, seed: u32) -> String {
    let (mut h, mut q, mut random) = ([0.0_f64; 2], 0.0, Random(seed));
    let mut text = "time [s],q [m^3/s],y [m]\n".to_owned();
    for k in 0..1200 {
        if k % 40 == 0 {
            q = 0.3 * random.uniform();
        }
        let noise = 0.005 * random.normal();
        writeln!(text, "{k},{q},{}", h[1] + noise).unwrap();
        for _ in 0..50 {
            let pipe = (0.103 * h[0]).min(most);
            h[0] += 0.02 * (q - pipe) / 1.02;
            h[1] += 0.02 * (pipe - 0.059 * h[1]) / 1.47;
        }
    }
    text
}

/// The pipe is a term of two equations, and one signal.
#[test]
fn a_pipe_between_two_vessels_that_takes_no_more() {
    let desk = Desk::new();
    desk.put("vessels.toml", MODEL);
    desk.put("run.csv", &log(0.15, 11));
    desk.put("later.csv", &log(0.15, 12));
    let output = desk.run(&[
        "--model",
        "vessels.toml",
        "--log",
        "run.csv",
        "--held-out",
        "later.csv",
        "--out",
        "out",
    ]);
    assert!(output.status.success(), "{output:?}");
    let text = stdout(&output);
    assert!(text.starts_with("Saturation on h1_term_1 = k1*h1 ("), "{text}");
    let report = desk.report();
    let cause = &report["diagnosis"]["causes"][0];
    assert_eq!(cause["site"]["kind"], "signal");
    let limit = cause["parameters"][0]["value"].as_f64().unwrap();
    // The strength is the inverse of the limit; it is known to a thousandth.
    assert!((1.0 / limit - 0.15).abs() < 1e-3, "{}", 1.0 / limit);
    // The patched model has the limit where it belongs.
    let patched = desk.read("out/patched.toml");
    assert!(patched.contains("h1_term_1 = \"k1*h1\""), "{patched}");
}

/// Where something around the plant explains the logs, nobody looks inside.
#[test]
fn a_plant_without_a_gap_stays_without() {
    let desk = Desk::new();
    desk.put("vessels.toml", MODEL);
    desk.put("run.csv", &log(f64::INFINITY, 13));
    let output = desk.run(&["--model", "vessels.toml", "--log", "run.csv", "--out", "out"]);
    assert!(stdout(&output).starts_with("No gap"), "{output:?}");
    assert!(!desk.read("out/report.json").contains("h1_term_1"));
}

const AMPLIFIER: &str = r#"
version = 1
kind = "equations"
name = "amplifier"
sample_time = 0.02

[parameters]
T1 = { unit = "s", value = 0.2, tolerance = 0.03 }
T2 = { unit = "s", value = 0.4, tolerance = 0.03 }
k = { unit = "1", value = 1.5, tolerance = 0.03 }

[inputs]
u = { unit = "V" }

[states]
a = { unit = "V", initial = 0.0, derivative = "(u - a)/T1" }
x = { unit = "V", initial = 0.0, derivative = "(w - x)/T2" }

[outputs]
y = { unit = "V", value = "x", noise = 0.01 }

[definitions]
w = "k*a/(1 + 0.08*a^2)"

[sites]
inlet = { unit = "V/s", enters = { a = 1.0 }, velocity = "a" }
outlet = { unit = "V/s", enters = { x = 1.0 }, velocity = "x" }
"#;

/// An amplifier between two filters, what it delivers bent by a law.
fn amplifier(seed: u32, law: fn(f64) -> f64) -> String {
    let (mut a, mut x, mut u, mut random) = (0.0_f64, 0.0, 0.0, Random(seed));
    let mut text = "time [s],u [V],y [V]\n".to_owned();
    for k in 0..500_u32 {
        if k % 30 == 0 {
            u = 8.0 * (random.uniform() - 0.5);
        }
        writeln!(text, "{},{u},{}", 0.02 * f64::from(k), x + 0.01 * random.normal()).unwrap();
        for _ in 0..20 {
            let w = law(1.51 * a / (1.0 + 0.08 * a * a));
            a += 1e-3 * (u - a) / 0.204;
            x += 1e-3 * (w - x) / 0.392;
        }
    }
    text
}

/// Friction at one of the filters stands for the dead zone, and two parameters that wander for the limit: in the fitted
/// log down to the noise.
#[test]
fn one_law_inside_instead_of_what_stands_for_it() {
    type Law = fn(f64) -> f64;
    let laws: [(&str, Law); 2] = [
        ("Dead zone on w", |w| w - w.clamp(-0.08, 0.08)),
        ("Saturation on w", |w| w.clamp(-2.5, 2.5)),
    ];
    for (named, law) in laws {
        let desk = Desk::new();
        desk.put("amplifier.toml", AMPLIFIER);
        desk.put("run.csv", &amplifier(21, law));
        desk.put("later.csv", &amplifier(22, law));
        let logs = ["--log", "run.csv", "--held-out", "later.csv", "--out", "out"];
        let output = desk.run(&[&["--model", "amplifier.toml"][..], &logs].concat());
        let text = stdout(&output);
        assert!(text.starts_with(named), "{text}");
    }
}
