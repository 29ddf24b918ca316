//! Logs whose clock jitters.

use std::fmt::Write;

use crate::gap::{
    desk::{Desk, stdout},
    random::Random,
};

const MODEL: &str = r#"
version = 1
kind = "equations"
name = "trolley"
sample_time = 0.02

[parameters]
M = { unit = "kg", value = 60.0, tolerance = 0.02 }
c = { unit = "N s/m", value = 45.0, tolerance = 0.1 }

[inputs]
F = { unit = "N" }

[states]
x = { unit = "m", initial = 0.0, derivative = "v" }
v = { unit = "m/s", initial = 0.0, derivative = "(F - c*v)/M" }

[outputs]
trolley = { unit = "m", value = "x", noise = 0.0025 }
"#;

/// A trolley that is exactly its model, in a loop whose steps are up to a fifth too long or too short; the noise of the
/// measurement is in the force of the same step.
fn log(seed: u32) -> String {
    let (mut x, mut v, mut random) = (0.0_f64, 0.0_f64, Random(seed));
    let mut text = "time [s],F [N],trolley [m]\n".to_owned();
    let (mut t, mut goal) = (0.0, 0.0);
    for k in 0..900_u32 {
        if k % 120 == 0 {
            goal = 2.0 * random.uniform() - 1.0;
        }
        let y = x + 0.0025 * random.normal();
        let force = 400.0 * (goal - y) - 200.0 * v;
        writeln!(text, "{t},{force},{y}").unwrap();
        // Where the next step is on the grid; the force is held until then, and Euler's steps are 0.1 ms long.
        let next = 0.02 * (f64::from(k + 1) + 0.4 * (random.uniform() - 0.5));
        let steps = ((next - t) / 1e-4).ceil();
        let h = (next - t) / steps;
        let mut i = 0.0;
        while i < steps {
            let rate = (force - 45.0 * v) / 60.0;
            x += h * (v + 0.5 * h * rate);
            v += h * rate;
            i += 1.0;
        }
        t = next;
    }
    text
}

/// The force of each step is held for as long as it was; taken for that of the time on the grid, it is late at every
/// second step, which no model explains.
#[test]
fn a_loop_with_a_clock_that_jitters_lacks_nothing() {
    let desk = Desk::new();
    desk.put("trolley.toml", MODEL);
    desk.put("run.csv", &log(17));
    desk.put("later.csv", &log(18));
    let columns = "inputs = [{ name = \"F\", unit = \"N\" }]\noutputs = [{ name = \"trolley\", unit = \"m\" }]\n";
    desk.put("latest.toml", &format!("{columns}[resample]\nheld_inputs = \"latest\"\n"));
    let plain = ["--model", "trolley.toml", "--log", "run.csv", "--held-out", "later.csv", "--out"];
    let output = desk.run(&[&plain[..], &["out"]].concat());
    assert!(stdout(&output).starts_with("No gap"), "{output:?}");
    let output =
        desk.run(&[&plain[..], &["latest", "--most", "1", "--columns", "latest.toml"]].concat());
    assert!(output.status.success(), "{output:?}");
    assert!(!stdout(&output).starts_with("No gap"), "{output:?}");
}

/// The trolley with a force that was measured, and goes on between two samples; their times are up to two fifths of a step off.
/// The chord of the force is so near its arc, 0.1 N, that both integrals of the difference stay within the noise.
fn measured(seed: u32) -> String {
    let (mut x, mut v, mut random) = (0.0_f64, 0.0_f64, Random(seed));
    let shift = f64::from(seed);
    let force = |t: f64| 80.0 * (2.5 * t + shift).sin() + 40.0 * (0.7 * t).sin();
    let mut text = "time [s],F [N],trolley [m]\n".to_owned();
    let mut t = 0.0;
    for k in 0..900_u32 {
        writeln!(text, "{t},{},{}", force(t), x + 1e-3 * random.normal()).unwrap();
        let next = 0.02 * (f64::from(k + 1) + 0.8 * (random.uniform() - 0.5));
        let h = (next - t) / 100.0;
        for i in 0..100 {
            // The middle of a step of 0.2 ms: what is missed is far below the noise.
            let rate = (force(t + h * (f64::from(i) + 0.5)) - 45.0 * v) / 60.0;
            x += h * (v + 0.5 * h * rate);
            v += h * rate;
        }
        t = next;
    }
    text
}

/// Taken for what it was at the sample before, such a force is late.
#[test]
fn a_measured_force_with_a_clock_that_jitters_is_not_late() {
    let desk = Desk::new();
    let model = MODEL.replace("sample_time = 0.02", "sample_time = 0.02\nhold = \"linear\"");
    desk.put("trolley.toml", &model.replace("noise = 0.0025", "noise = 1e-3"));
    desk.put("run.csv", &measured(1));
    desk.put("later.csv", &measured(2));
    let columns = "inputs = [{ name = \"F\", unit = \"N\" }]\noutputs = [{ name = \"trolley\", unit = \"m\" }]\n";
    desk.put("latest.toml", &format!("{columns}[resample]\nheld_inputs = \"latest\"\n"));
    let plain = ["--model", "trolley.toml", "--log", "run.csv", "--held-out", "later.csv", "--out"];
    let output = desk.run(&[&plain[..], &["out"]].concat());
    assert!(stdout(&output).starts_with("No gap"), "{output:?}");
    let latest = ["latest", "--most", "1", "--as-read", "--columns", "latest.toml"];
    let output = desk.run(&[&plain[..], &latest].concat());
    assert!(output.status.success(), "{output:?}");
    assert!(!stdout(&output).starts_with("No gap"), "{output:?}");
}
