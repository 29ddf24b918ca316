//! One law at several places, with one strength.

use fd_effect::{EverySite, SiteRef, library};
use fd_gap::diagnose::{Case, Settings, Verdict, diagnose};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::{model::Model, scales::ReplayScales};

/// Two carriages on rails of their own.
const MODEL: &str = r#"
version = 1
kind = "equations"
name = "gantry"
sample_time = 0.02
inputs = { a = { unit = "N" }, b = { unit = "N" } }
outputs = { p = { unit = "m/s", value = "v", noise = 0.01 }, q = { unit = "m/s", value = "w", noise = 0.01 } }
[states]
v = { unit = "m/s", initial = 0.0, derivative = "a - v" }
w = { unit = "m/s", initial = 0.0, derivative = "2*b - 3*w" }
"#;

const SAMPLES: usize = 600;
/// Steps of a sample.
const STEPS: usize = 20;
/// Both commands come so many steps late, as over one bus.
const LATE: usize = 53;

fn reality(model: &Model, seed: u64) -> Record {
    let [on_p, on_q] =
        [0, 1].map(|output| WhiteNoise::new(0.01, 2 * seed + output).values(SAMPLES).unwrap());
    let command = |k: usize| {
        let t = k as f64 + 1000.0 * seed as f64;
        // Steps, as a position servo makes them.
        [(0.05 * t).sin().signum() + 0.3, 0.7 * (0.083 * t).cos().signum() - 0.2]
    };
    let (mut v, mut w) = (0.0_f64, 0.0_f64);
    let rows = (0..SAMPLES).map(|k| {
        let row = (command(k), [v + on_p[k], w + on_q[k]]);
        for step in STEPS * k..STEPS * (k + 1) {
            let [a, b] = if step < LATE { command(0) } else { command((step - LATE) / STEPS) };
            // Exact over a step, in which commands are held.
            let dt = 0.02 / STEPS as f64;
            v = a + (v - a) * (-dt).exp();
            w = 2.0 * b / 3.0 + (w - 2.0 * b / 3.0) * (-3.0 * dt).exp();
        }
        row
    });
    let rows: Vec<([f64; 2], [f64; 2])> = rows.collect();
    let (inputs, outputs) = (model.external_inputs(), model.output_channels());
    Record::from_rows(inputs, outputs, rows, model.sample_time().unwrap()).unwrap()
}

/// At one place alone a delay explains half of the gap; with all places alike it is one cause, with one time.
#[test]
fn commands_that_all_come_late_are_one_cause() {
    let model: Model = MODEL.parse().unwrap();
    let (logs, held_out) = ([reality(&model, 1)], [reality(&model, 2)]);
    let ts = model.sample_time().unwrap();
    let u: Vec<f64> = (0..SAMPLES).flat_map(|k| logs[0].u(k).to_vec()).collect();
    let scales = ReplayScales::of(&model, ts, &u, SAMPLES).unwrap();
    let suspects = EverySite::new(library(), &model, scales);
    let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
    let found = diagnose(&case, &Settings::default(), &()).unwrap();
    // In an open loop, sensors that are all late are the same.
    assert!(matches!(found.verdict, Verdict::Cause | Verdict::Tied), "{:?}", found.verdict);
    let late: Vec<_> = found.causes.iter().filter(|c| c.label.ends_with("-delay")).collect();
    let together: Vec<_> =
        late.iter().filter(|cause| matches!(cause.site, SiteRef::Alike(..))).collect();
    let probability: f64 = together.iter().map(|cause| cause.probability).sum();
    assert!(0.9 < probability, "{:?}", found.causes);
    let time = &found.causes[0].parameters[0];
    let truth = LATE as f64 * 0.02 / STEPS as f64;
    assert!((time.value - truth).abs() < 4.0 * time.standard_error + 1e-4, "{time:?}");
}
