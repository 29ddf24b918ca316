//! A week of three plants, a sample every 10 s.

use std::{fmt::Write, fs};

use super::{MODEL, Plant, SPEC};

/// Samples of a week.
const WEEK: usize = 60_480;
/// A fault every eight hours, for one hour.
const EVERY: usize = 2880;
const LASTS: usize = 360;

/// Where a fault is, in s.
pub struct Fault {
    pub unit: String,
    pub from: f64,
    pub to: f64,
}

/// Writes model and healthy log into the folder of a plant; the stream, and its faults.
pub fn write(plant: &Plant) -> (String, Vec<Fault>) {
    let slow = MODEL.replace("sample_time = 0.1", "sample_time = 10.0");
    assert_ne!(slow, MODEL);
    fs::write(plant.path("model.toml"), slow).unwrap();
    // A drift is near the threshold for long: an alarm ends when ten minutes were well.
    let patient = SPEC.replace("clear = 5 ", "clear = 60 ");
    assert_ne!(patient, SPEC);
    fs::write(plant.path("spec.toml"), patient).unwrap();
    let mut log = "time,fuel,speed,temperature\n".to_owned();
    for (k, (u, y)) in Plant::run_of(5000, 0).samples().enumerate() {
        writeln!(log, "{},{},{},{}", 10 * k, u[0], y[0], y[1]).unwrap();
    }
    fs::write(plant.path("healthy.csv"), log).unwrap();

    let runs: Vec<_> = (0..3).map(|unit| Plant::run_of(WEEK, 20 + unit)).collect();
    let (mut stream, mut faults) = (String::new(), Vec::new());
    for k in 0..WEEK {
        for (unit, run) in runs.iter().enumerate() {
            // The faults of the units are an hour and a half apart.
            let phase = (k + EVERY - 500 - 540 * unit) % EVERY;
            let number = (k + EVERY - 500 - 540 * unit) / EVERY;
            let (u, y) = (run.u(k)[0], run.y(k));
            let mut y = [y[0], y[1]];
            // Day and night, of which nobody should hear.
            let day = 2e-4 * (k as f64 * std::f64::consts::TAU / 8640.0).sin();
            y = y.map(|y| y + day);
            let is_fault = 0 < number && phase < LASTS;
            if is_fault {
                // In turn a step and a drift, of either sensor.
                let size =
                    if number.is_multiple_of(2) { 0.1 } else { 0.2 * phase as f64 / LASTS as f64 };
                y[number / 2 % 2] += size;
            }
            if is_fault && phase == 0 {
                let (from, to) = (10.0 * k as f64, 10.0 * (k + LASTS) as f64);
                faults.push(Fault { unit: format!("u{unit}"), from, to });
            }
            writeln!(
                stream,
                "{{\"rig\":\"u{unit}\",\"time\":{},\"fuel\":{u:.6},\"speed\":{:.6},\"temperature\":{:.6}}}",
                10 * k,
                y[0],
                y[1]
            )
            .unwrap();
        }
    }
    (stream, faults)
}
