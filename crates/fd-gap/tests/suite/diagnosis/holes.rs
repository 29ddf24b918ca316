//! Rows that were lost, with their inputs.

use std::ops::Range;

use fd_effect::{EverySite, library};
use fd_gap::{
    diagnose::{Case, Settings, Verdict, diagnose},
    fit::{Horizon, Plan},
};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::{model::Model, scales::ReplayScales};

/// A belt that forgets its start within seconds.
const BELT: &str = r#"
version = 1
kind = "equations"
name = "belt"
sample_time = 0.05
[parameters]
T = { unit = "s", value = 0.4, tolerance = 0.05 }
[inputs]
u = { unit = "m/s" }
[states]
v = { unit = "m/s", initial = 0.0, derivative = "(u - v)/T" }
[outputs]
speed = { unit = "m/s", value = "v", noise = 0.01 }
"#;

/// A hopper that never forgets.
const HOPPER: &str = r#"
version = 1
kind = "equations"
name = "hopper"
sample_time = 0.05
[parameters]
A = { unit = "m^2", value = 0.8, tolerance = 0.05 }
[inputs]
u = { unit = "m^3/s" }
[states]
h = { unit = "m", initial = 0.0, derivative = "u/A" }
[outputs]
level = { unit = "m", value = "h", noise = 0.01 }
"#;

const SAMPLES: usize = 800;
/// Rows that were lost.
const HOLES: [Range<usize>; 3] = [130..150, 400..425, 610..622];

/// A log of a plant whose input passes a dead zone of this half width, without the rows that were lost.
fn log(model: &Model, dead: f64, seed: u64) -> Record {
    let noise = WhiteNoise::new(0.01, seed).values(SAMPLES).unwrap();
    let levels = WhiteNoise::new(1.0, seed + 100).values(SAMPLES / 8 + 1).unwrap();
    let decay = (-0.05_f64 / 0.4).exp();
    let mut x = 0.0;
    let rows = (0..SAMPLES).map(|k| {
        let u: f64 = levels[k / 8];
        let y = x + noise[k];
        let enters = (u.abs() - dead).max(0.0).copysign(u);
        // Exact for an input that is held.
        x = if model.name == "belt" {
            decay * x + (1.0 - decay) * enters
        } else {
            x + 0.0625 * enters
        };
        if HOLES.iter().any(|hole| hole.contains(&k)) {
            ([f64::NAN], [f64::NAN])
        } else {
            ([u], [y])
        }
    });
    let rows: Vec<([f64; 1], [f64; 1])> = rows.collect();
    let (inputs, outputs) = (model.external_inputs(), model.output_channels());
    Record::from_rows(inputs, outputs, rows, model.sample_time().unwrap()).unwrap()
}

fn answer(text: &str, dead: f64) -> (Verdict, Option<&'static str>) {
    let model: Model = text.parse().unwrap();
    let (logs, held_out) = ([log(&model, dead, 3)], [log(&model, dead, 5)]);
    let u: Vec<f64> = (0..SAMPLES)
        .map(|k| logs[0].u(k)[0])
        .map(|u| if u.is_finite() { u } else { 0.0 })
        .collect();
    let scales = ReplayScales::of(&model, logs[0].ts(), &u, SAMPLES).unwrap();
    let few = ["input-dead-zone", "input-gain", "input-lag", "sensor-bias", "sensor-outliers"];
    let effects = library().into_iter().filter(|e| few.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, &model, scales);
    let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
    let found = diagnose(&case, &Settings::default(), &()).unwrap();
    (found.verdict, found.causes.first().map(|cause| cause.label))
}

/// What the inputs did in a hole is unknown, and no effect explains it.
#[test]
fn lost_rows_are_no_gap() {
    for plant in [BELT, HOPPER] {
        assert_eq!(answer(plant, 0.0).0, Verdict::NoGap, "{plant}");
    }
}

#[test]
fn beside_lost_rows_an_effect_is_found() {
    for plant in [BELT, HOPPER] {
        assert_eq!(answer(plant, 0.3), (Verdict::Cause, Some("input-dead-zone")), "{plant}");
    }
}

/// The belt forgets: its log stays one segment with fewer values. The hopper begins anew behind each hole, and loses
/// nothing.
#[test]
fn a_plant_that_does_not_forget_begins_anew() {
    let plan = |text: &str| {
        let model: Model = text.parse().unwrap();
        let simulator = fd_sim::simulate::Nominal::simulator(&model, model.sample_time().unwrap());
        Plan::new(&*simulator.unwrap(), &[log(&model, 0.0, 3)], Horizon::FreeRun).unwrap()
    };
    let lost: usize = HOLES.iter().map(ExactSizeIterator::len).sum();
    let (belt, hopper) = (plan(BELT), plan(HOPPER));
    assert_eq!(belt.segments().len(), 1);
    assert!(belt.measured() < SAMPLES - lost);
    // Six time constants, which are 48 samples, leave half the noise of two units.
    assert!(SAMPLES - lost - 3 * 60 < belt.measured(), "{}", belt.measured());
    let starts: Vec<usize> = hopper.segments().iter().map(|segment| segment.from).collect();
    assert_eq!(starts, [0, 150, 425, 622]);
    assert_eq!(hopper.measured(), SAMPLES - lost);
}
