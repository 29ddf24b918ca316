//! Logs that begin in motion.

use fd_effect::{EverySite, library};
use fd_gap::diagnose::{Case, Settings, Verdict, diagnose};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::{model::Model, scales::ReplayScales};

/// A car on a road, which is said to begin at 22 m/s.
const CAR: &str = r#"
version = 1
kind = "equations"
name = "car"
sample_time = 0.2
[parameters]
m = { unit = "kg", value = 1450.0, tolerance = 0.03 }
c = { unit = "N s^2/m^2", value = 0.42, tolerance = 0.06 }
fr = { unit = "N", value = 190.0, tolerance = 0.1 }
[inputs]
F = { unit = "N" }
[states]
vx = { unit = "m/s", initial = 22.0, tolerance = 0.4, derivative = "(F - c*vx*vx - fr)/m" }
[outputs]
speed = { unit = "m/s", value = "vx" }
[sites]
road = { unit = "N", enters = { vx = "1/m" }, velocity = "vx" }
"#;

const SAMPLES: usize = 560;

/// What a car of these parameters does, begun at a speed, seen by a sensor with a bias.
fn drive(model: &Model, begin: f64, bias: f64, seed: u64) -> Record {
    let noise = WhiteNoise::new(0.06, seed).values(SAMPLES).unwrap();
    let mut v = begin;
    let rows = (0..SAMPLES).map(|k| {
        let t = 0.2 * k as f64 + 17.0 * seed as f64;
        let square = 300.0_f64.copysign((0.18 * t).sin());
        let force = 900.0 + 500.0 * (0.11 * t).sin() + square;
        let y = v + bias + noise[k];
        // Forty Euler steps; the largest rate is 0.03/s.
        for _ in 0..40 {
            v += 0.005 * (force - 0.44 * v * v - 181.0) / 1445.0;
        }
        ([force], [y])
    });
    let rows: Vec<([f64; 1], [f64; 1])> = rows.collect();
    let (inputs, outputs) = (model.external_inputs(), model.output_channels());
    Record::from_rows(inputs, outputs, rows, model.sample_time().unwrap()).unwrap()
}

/// The answer, with all effects of a sensor and of the road as suspects.
fn answer(begins: [f64; 2], bias: f64) -> (Verdict, Option<&'static str>) {
    let model: Model = CAR.parse().unwrap();
    let [fitted, held_out] = [drive(&model, begins[0], bias, 3), drive(&model, begins[1], bias, 9)];
    let u: Vec<f64> = (0..SAMPLES).flat_map(|k| fitted.u(k).to_vec()).collect();
    let scales = ReplayScales::of(&model, fitted.ts(), &u, SAMPLES).unwrap();
    let few = [
        "sensor-bias",
        "sensor-scale",
        "sensor-drift",
        "viscous-friction",
        "constant-load",
        "input-gain",
    ];
    let effects = library().into_iter().filter(|e| few.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, &model, scales);
    let (logs, held_out) = ([fitted], [held_out]);
    let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
    let found = diagnose(&case, &Settings::default(), &()).unwrap();
    (found.verdict, found.causes.first().map(|cause| cause.label))
}

/// A sensor bias and a friction together do what one free start does: the start is the plainer answer.
#[test]
fn a_car_that_is_faster_than_said_at_the_start_lacks_nothing() {
    assert_eq!(answer([26.0, 33.0], 0.0).0, Verdict::NoGap);
    assert_eq!(answer([18.0, 30.0], 0.0).0, Verdict::NoGap);
}

/// One effect against one start is no matter of plainness: drag, which goes by the true speed, tells them apart.
#[test]
fn a_sensor_that_reads_too_much_is_no_motion() {
    assert_eq!(answer([22.0, 22.0], 4.0), (Verdict::Cause, Some("sensor-bias")));
}

/// A cylinder that stands elsewhere than it is said to, and never forgets it; the sensor of its load is slow.
#[test]
fn a_position_that_begins_elsewhere_hides_no_other_effect() {
    let model: Model = r#"
        version = 1
        kind = "equations"
        name = "cylinder"
        sample_time = 0.01
        [parameters]
        tau = { unit = "s", value = 0.08, tolerance = 0.05 }
        [inputs]
        u = { unit = "m/s" }
        [states]
        x = { unit = "m", initial = 0.0, tolerance = 0.001, derivative = "v" }
        v = { unit = "m/s", initial = 0.0, tolerance = 0.001, derivative = "(u - v)/tau" }
        [outputs]
        stroke = { unit = "m", value = "x", noise = 0.001 }
        speed = { unit = "m/s", value = "v", noise = 0.01 }
        "#
    .parse()
    .unwrap();
    let ran = |seed: u64| {
        let noise = WhiteNoise::new(1.0, seed).values(2 * SAMPLES).unwrap();
        let (mut x, mut v, mut shown) = (0.3, 0.4, 0.4);
        let rows = (0..SAMPLES).map(|k| {
            let t = 0.01 * k as f64 + seed as f64;
            let u = (2.1 * t).sin() + 0.6_f64.copysign((5.3 * t).sin());
            let y = [x + 1e-3 * noise[2 * k], shown + 0.01 * noise[2 * k + 1]];
            // Twenty Euler steps; the largest rate is 17/s.
            for _ in 0..20 {
                x += 5e-4 * v;
                v += 5e-4 * (u - v) / 0.081;
                shown += 5e-4 * (v - shown) / 0.06;
            }
            ([u], y)
        });
        let rows: Vec<([f64; 1], [f64; 2])> = rows.collect();
        let (inputs, outputs) = (model.external_inputs(), model.output_channels());
        Record::from_rows(inputs, outputs, rows, model.sample_time().unwrap()).unwrap()
    };
    let (logs, held_out) = ([ran(3)], [ran(9)]);
    let u: Vec<f64> = (0..SAMPLES).flat_map(|k| logs[0].u(k).to_vec()).collect();
    let scales = ReplayScales::of(&model, logs[0].ts(), &u, SAMPLES).unwrap();
    let few = ["sensor-bias", "sensor-lag", "input-gain", "viscous-friction"];
    let effects = library().into_iter().filter(|e| few.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, &model, scales);
    let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
    let found = diagnose(&case, &Settings::default(), &()).unwrap();
    let first = &found.causes[0];
    assert_eq!((found.verdict, first.label), (Verdict::Cause, "sensor-lag"));
    assert_eq!(first.site.name(), Some("speed"));
}
