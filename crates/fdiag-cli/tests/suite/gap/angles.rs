//! Angles that begin anew after a turn.

use std::fmt::Write;

use crate::gap::{
    desk::{Desk, stdout},
    random::Random,
};

const MODEL: &str = r#"
version = 1
kind = "equations"
name = "turntable"
sample_time = 0.1

[parameters]
T = { unit = "s", value = 0.8, tolerance = 0.03 }

[inputs]
u = { unit = "rad/s" }

[states]
q = { unit = "rad", initial = 0.0, derivative = "w" }
w = { unit = "rad/s", initial = 0.0, derivative = "(u - w)/T" }

[outputs]
angle = { unit = "rad", value = "q", noise = 0.01 }
"#;

/// A table that turns by 8 degrees a sample; the drive gives `gain` of its command. The encoder shows degrees from 0 to 360, at
/// times that are not those of the model, so that values are read between the rows.
fn run(gain: f64, seed: u32) -> String {
    let (mut angle, mut speed, mut random) = (0.0_f64, 0.0_f64, Random(seed));
    let mut text = "time [s],u [rad/s],angle [deg]\n".to_owned();
    let (h, fading) = (0.05, f64::exp(-0.05 / 0.8));
    for k in 0..1200 {
        let command = 1.4 + 0.5_f64.copysign((0.031 * f64::from(k)).sin());
        let shown = (angle + 0.01 * random.normal()).to_degrees().rem_euclid(360.0);
        writeln!(text, "{:.2},{command},{shown:.4}", h * f64::from(k)).unwrap();
        let wanted = gain * command;
        angle += wanted * h + (speed - wanted) * 0.8 * (1.0 - fading);
        speed = wanted + (speed - wanted) * fading;
    }
    text
}

fn told(desk: &Desk, model: &str, more: &[&str]) -> String {
    desk.put("model.toml", model);
    let few = ["--only", "input-gain", "--only", "sensor-delay", "--held-out", "friday.csv"];
    let output = desk.command(&[&few[..], more].concat()).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    stdout(&output)
}

#[test]
fn a_turn_is_no_gap_where_it_is_declared() {
    let desk = Desk::new();
    desk.put("monday.csv", &run(1.0, 1));
    desk.put("friday.csv", &run(1.0, 2));
    let declared = MODEL.replace("noise = 0.01", "noise = 0.01, wraps = true");
    let text = told(&desk, &declared, &[]);
    assert!(text.starts_with("No gap: "), "{text}");
    // The same by the column map, for a model that says nothing of it.
    desk.put("map.toml", "outputs = [{ name = \"angle\", wraps = true }]\n");
    let text = told(&desk, MODEL, &["--columns", "map.toml"]);
    assert!(text.starts_with("No gap: "), "{text}");
    let text = told(&desk, MODEL, &[]);
    assert!(
        text.starts_with("Check the log first: monday.csv, `angle`: the angle jumps by a turn"),
        "{text}"
    );
    desk.put("monday.csv", &run(0.9, 3));
    desk.put("friday.csv", &run(0.9, 4));
    let text = told(&desk, &declared, &[]);
    assert!(text.starts_with("Gain error at input u (-10.0"), "{text}");
}

#[test]
fn what_is_no_angle_does_not_wrap() {
    let desk = Desk::new();
    desk.put("map.toml", "outputs = [{ name = \"speed\", wraps = true }]\n");
    let output = desk.command(&["--columns", "map.toml"]).output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{text}");
    assert!(text.contains("`m/s` (Velocity) cannot be converted to `rad` (Angle)"), "{text}");
    let spoiled = desk
        .read("model.toml")
        .replace("unit = \"m/s\", value", "unit = \"m/s\", wraps = true, value");
    desk.put("model.toml", &spoiled);
    let output = desk.command(&[]).output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{text}");
    assert!(
        text.contains("`wraps = true` is for angles") && text.contains("found `m/s`"),
        "{text}"
    );
}
