//! `fdiag compensate` with a nonlinear model in the spec, from files to the report.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{fs, path::Path, process::Command};

use fdiag::{
    log::write_log,
    model::{Channel, Record, SampleTime, signal::WhiteNoise},
    sim::{
        model::Model,
        simulate::{EquationSimulator, Simulator},
    },
};

/// Two tanks in a row; outflows go with the root of the level.
const TANKS: &str = r#"
version = 1
kind = "equations"
name = "tanks"
sample_time = 2.0
[parameters]
k = { unit = "m^2.5/s", value = 0.1, tolerance = 0.0 }
[inputs]
q = { unit = "m^3/s" }
[states]
h_1 = { unit = "m", initial = 1.0, tolerance = 0.05, derivative = "q - k*sqrt(h_1)" }
h_2 = { unit = "m", initial = 1.0, tolerance = 0.05, derivative = "k*sqrt(h_1) - k*sqrt(h_2)" }
[outputs]
upper = { unit = "m", value = "h_1", noise = 0.005 }
lower = { unit = "m", value = "h_2", noise = 0.005 }
"#;

/// The same linearised at 1 m: each tank forgets at k/2 per second.
const LINEAR: &str = r#"
version = 1
kind = "state-space"
name = "tanks about 1 m"
inputs = [{ name = "q", unit = "m^3/s", operating_point = 0.1, scale = 0.01 }]
outputs = [
    { name = "upper", unit = "m", operating_point = 1.0, scale = 0.1 },
    { name = "lower", unit = "m", operating_point = 1.0, scale = 0.1 },
]
[matrices]
A = [[-0.05, 0.0], [0.05, -0.05]]
B = [[0.1], [0.0]]
C = [[1.0, 0.0], [0.0, 1.0]]
"#;

/// Levels between 0.5 m and 2 m; from sample `fault` on the lower sensor reads 0.04 m too much.
fn log(samples: usize, seed: u64, fault: usize) -> Record {
    let model: Model = TANKS.parse().unwrap();
    let mut plant = EquationSimulator::<f64>::new(&model).unwrap();
    let u: Vec<f64> = (0..samples)
        .map(|k| {
            let (k, seed) = (k as f64, seed as f64);
            0.105 + 0.03 * ((k / 40.0).floor() * 1.7 + seed).sin() + 0.004 * (0.11 * k + seed).sin()
        })
        .collect();
    let mut y = vec![0.0; 2 * samples];
    Simulator::simulate(&mut plant, &model.nominal(), &model.initial(), &u, &mut y);
    for sensor in 0..2 {
        let noise = WhiteNoise::new(0.005, 10 * seed + sensor).values(samples).unwrap();
        for (k, noise) in noise.into_iter().enumerate() {
            let wrong = if sensor == 1 && fault <= k { 0.04 } else { 0.0 };
            y[2 * k + usize::try_from(sensor).unwrap()] += noise + wrong;
        }
    }
    let outputs = vec![Channel::new("upper", "m"), Channel::new("lower", "m")];
    let ts = SampleTime::new(2.0).unwrap();
    Record::new(vec![Channel::new("q", "m^3/s")], outputs, u, y, ts).unwrap()
}

fn report(folder: &Path, spec: &str) -> serde_json::Value {
    fs::write(folder.join("specs/spec.toml"), spec).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
    let line = "compensate --model linear.toml --log healthy.csv --log later.csv --spec specs/spec.toml --json";
    let output = command.args(line.split_whitespace()).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{spec}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn nonlinear_generators_work_from_files_to_the_report() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::create_dir(folder.join("specs")).unwrap();
    fs::write(folder.join("linear.toml"), LINEAR).unwrap();
    // Beside the spec, where its path begins.
    fs::write(folder.join("specs/tanks.toml"), TANKS).unwrap();
    write_log(folder.join("healthy.csv"), &log(1500, 1, usize::MAX)).unwrap();
    write_log(folder.join("later.csv"), &log(600, 2, 400)).unwrap();
    let rest = "settle_s = 100.0\ndetector = { kind = \"maximum\", margin = 0.5 }\n\
                rule = { raise = 3, out_of = 3 }\nbias.orders = { kind = \"fixed\", na = 1, nb = 2 }\n";
    let rms = |report: &serde_json::Value| report["logs"][0]["rms_primary"][1].as_f64().unwrap();
    let linear = format!(
        "{rest}[generator]\nkind = \"kalman\"\nprocess_noise = 2e-4\noutput_noise = 2.5e-3\n"
    );
    let linear = rms(&report(folder, &linear));
    for generator in [
        "kind = \"extended\"\nprocess_noise = { h_1 = 1e-3, h_2 = 1e-3 }",
        "kind = \"unscented\"\nprocess_noise = { h_1 = 1e-3, h_2 = 1e-3 }",
        "kind = \"particle\"\nprocess_noise = { h_1 = 1e-3, h_2 = 1e-3 }\nparticles = 300",
        "kind = \"patched\"",
    ] {
        let spec = format!("{rest}[generator]\n{generator}\nmodel = \"tanks.toml\"\n");
        let report = report(folder, &spec);
        // The noise of the sensor is 0.005 m, 0.05 in the scale of the report.
        let own = rms(&report);
        assert!(own < 0.06 && own < 0.8 * linear, "{generator}: {own} {linear}");
        let first = report["logs"][1]["first_alarm_s"][0].as_f64();
        assert!(first.is_some_and(|t| (800.0..900.0).contains(&t)), "{generator}: {first:?}");
    }
    let spec = "[generator]\nkind = \"extended\"\nprocess_noise = 0.1\nmodel = \"gone.toml\"";
    fs::write(folder.join("specs/spec.toml"), spec).unwrap();
    let line = "compensate --model linear.toml --log healthy.csv --spec specs/spec.toml";
    let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
    let output = command.args(line.split_whitespace()).current_dir(folder).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{error}");
    assert!(error.contains("gone.toml") && !error.contains("panicked"), "{error}");
}
