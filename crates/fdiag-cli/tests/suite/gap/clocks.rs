//! Held-out logs on the clock of the fitted one, or with one of their own.

use std::fmt::Write;

use fdiag::gap_study::{GapStudy, HeldOutChoice, Request, Signals};

use crate::gap::{desk::Desk, random::Random};

const MODEL: &str = r#"
version = 1
kind = "equations"
name = "vessel"
sample_time = 1.0

[parameters]
C = { unit = "s", value = 20.0, tolerance = 0.03 }

[inputs]
P = { unit = "K" }

[states]
T = { unit = "K", initial = 0.0, tolerance = 0.5, derivative = "(P - T)/C" }

[outputs]
reading = { unit = "K", value = "T", noise = 0.05 }
"#;

/// A run of a vessel that begins at a time, of which the sensor drifts by 2 mK/s; stamps count from another time.
fn run(samples: u32, begin: f64, stamped: f64, seed: u32) -> String {
    let (mut temperature, mut random) = (0.0_f64, Random(seed));
    let mut text = "time [s],P [K],reading [K]\n".to_owned();
    for k in (0..samples).map(f64::from) {
        let power = 10.0 + 6.0 * (0.031 * k).sin() + 4.0_f64.copysign((0.013 * k).sin());
        let reading = temperature + 0.002 * (begin + k) + 0.05 * random.normal();
        writeln!(text, "{},{power},{reading}", stamped + k).unwrap();
        temperature = power + (-1.0_f64 / 20.0).exp() * (temperature - power);
    }
    text
}

/// Root of the mean square of what the picture of the answer leaves of the held-out log, where it is forecast.
fn left_in_the_picture(desk: &Desk, only: &[&str]) -> f64 {
    let mut request = Request::new(desk.path("model.toml"), [desk.path("monday.csv")]);
    request.held_out = HeldOutChoice::Logs(vec![desk.path("friday.csv")]);
    request.only = only.iter().map(|label| (*label).to_owned()).collect();
    let trace = GapStudy::run(&request, &()).unwrap().trace.unwrap();
    let Signals { measured, after, .. } = &trace.outputs[0];
    let errors = measured.iter().zip(after).map(|(measured, after)| measured - after);
    let forecast: Vec<f64> = errors.filter(|error| error.is_finite()).collect();
    assert_eq!(forecast.len(), 300, "of 400 samples, a quarter settles the state");
    fd_numeric::rms(forecast)
}

/// A quarter of an hour lies between the runs. With stamps on one clock nothing has to be sought, and nothing is said of clocks.
#[test]
fn a_drift_goes_on_by_the_stamps_of_a_later_log() {
    let desk = Desk::new();
    desk.put("model.toml", MODEL);
    // Of a day in seconds, as loggers count.
    desk.put("monday.csv", &run(600, 0.0, 36_000.0, 1));
    let held_out = ["--held-out", "friday.csv", "--only", "sensor-drift", "--only", "input-gain"];
    for (stamped, is_said) in [(37_500.0, false), (0.0, true)] {
        desk.put("friday.csv", &run(400, 1500.0, stamped, 2));
        desk.gap(&held_out);
        let report = desk.report();
        assert_eq!(report["diagnosis"]["causes"][0]["label"], "sensor-drift");
        let closed = &report["diagnosis"]["held_out"][0]["closed_of_refit"]["fraction"];
        assert!(0.9 < closed.as_f64().unwrap(), "{closed}");
        let findings = report["findings"].as_array().unwrap();
        let is_clock = findings.iter().any(|finding| finding["defect"]["kind"] == "clock");
        assert_eq!(is_clock, is_said, "{findings:?}");
        // Noise of 50 mK; from zero on the drift would be 3 K off.
        let left = left_in_the_picture(&desk, &["sensor-drift", "input-gain"]);
        assert!(left < 0.1, "{left}");
    }
}
