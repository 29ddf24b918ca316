//! Effects that belong to one run, on a log whose clock begins anew.

use std::f64::consts::TAU;

use fd_effect::{EverySite, library};
use fd_gap::{
    diagnose::{Case, Diagnosis, Settings, Verdict, diagnose},
    fit::Log,
};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::{model::Model, scales::ReplayScales, simulate::EquationSimulator};

/// A vessel that is heated, with losses.
const VESSEL: &str = r#"
version = 1
kind = "equations"
name = "vessel"
sample_time = 1.0
[parameters]
C = { unit = "s", value = 20.0, tolerance = 0.03 }
loss = { unit = "1", value = 1.0, tolerance = 0.03 }
[inputs]
P = { unit = "K" }
[states]
T = { unit = "K", initial = 0.0, tolerance = 0.5, derivative = "(P - loss*T)/C" }
[outputs]
reading = { unit = "K", value = "T", noise = 0.05 }
[sites]
wall = { unit = "K", enters = { T = "1/C" } }
"#;

const FITTED: usize = 600;
const HELD_OUT: usize = 400;

/// One run of the vessel, cut in two, the clock of the second part set to zero: `of(t)` is the disturbance of the heating
/// power, the loss relative to its nominal value, and what the sensor adds.
fn cut(model: &Model, of: impl Fn(f64) -> [f64; 3]) -> [Record; 2] {
    let noise = WhiteNoise::new(0.05, 7).values(FITTED + HELD_OUT).unwrap();
    let mut temperature = 0.0;
    let rows = (0..FITTED + HELD_OUT).map(|k| {
        let t = k as f64;
        let power = 10.0 + 6.0 * (0.031 * t).sin() + 4.0_f64.copysign((0.013 * t).sin());
        let row = ([power], [temperature + of(t)[2] + noise[k]]);
        // A hundred Euler steps; the largest rate is 0.07/s.
        for i in 0..100 {
            let [added, loss, _] = of(t + 0.01 * f64::from(i));
            temperature += 0.01 * (power + added - 0.99 * loss * temperature) / 20.3;
        }
        row
    });
    let rows: Vec<([f64; 1], [f64; 1])> = rows.collect();
    let record = |rows: &[([f64; 1], [f64; 1])]| {
        let (inputs, outputs) = (model.external_inputs(), model.output_channels());
        let rows = rows.iter().copied();
        Record::from_rows(inputs, outputs, rows, model.sample_time().unwrap()).unwrap()
    };
    [record(&rows[..FITTED]), record(&rows[FITTED..])]
}

fn diagnosed(of: impl Fn(f64) -> [f64; 3]) -> Diagnosis {
    let model: Model = VESSEL.parse().unwrap();
    let [fitted, held_out] = cut(&model, of);
    let u: Vec<f64> = (0..FITTED).flat_map(|k| fitted.u(k).to_vec()).collect();
    let scales = ReplayScales::of(&model, fitted.ts(), &u, FITTED).unwrap();
    let few = [
        "periodic-force",
        "sensor-drift",
        "parameter-wander",
        "sensor-scale",
        "input-gain",
        "input-lag",
        "viscous-friction",
    ];
    let effects = library().into_iter().filter(|e| few.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, &model, scales);
    let (logs, held_out) = ([fitted], [held_out]);
    let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
    diagnose(&case, &Settings::default(), &()).unwrap()
}

/// The share of the held-out gap that the answer closes, at the first horizon.
fn closes(diagnosis: &Diagnosis) -> f64 {
    diagnosis.held_out[0].closed_of_refit.unwrap().fraction
}

/// Six hundred samples are 14.6 periods, so that the wave has another phase where the clock begins anew.
#[test]
fn a_periodic_force_has_another_phase() {
    let found = diagnosed(|t| [1.5 * (TAU * t / 41.0).sin(), 1.0, 0.0]);
    assert_eq!((found.verdict, found.causes[0].label), (Verdict::Cause, "periodic-force"));
    assert!(0.9 < closes(&found), "{}", closes(&found));
}

/// Stamps say how long after the first run another one began, if they are on one clock.
#[test]
fn a_later_run_on_the_same_clock_begins_on_it() {
    let model: Model = VESSEL.parse().unwrap();
    let [fitted, later] = cut(&model, |_| [0.0, 1.0, 0.0]);
    let simulator = EquationSimulator::<f64>::at(&model, fitted.ts()).unwrap();
    let fitted = fitted.starting_at(50.0);
    // Zeroed, within the first run, at its end, after a pause.
    for (start, first) in [(0.0, 0), (400.0, 0), (650.0, 600), (1550.3, 1500)] {
        let later = later.clone().starting_at(start);
        let log = Log::new(&later, &simulator, 1).unwrap();
        let log = log.continuing(&later, std::slice::from_ref(&fitted), &simulator).unwrap();
        assert_eq!(log.first(), first, "{start}");
    }
}

/// The sensor is off by 1.2 K where the second part begins.
#[test]
fn a_drift_goes_on() {
    let found = diagnosed(|t| [0.0, 1.0, 0.002 * t]);
    assert_eq!((found.verdict, found.causes[0].label), (Verdict::Cause, "sensor-drift"));
    assert!(0.9 < closes(&found), "{}", closes(&found));
}

/// The loss goes up and down in the first part and stays high in the second. No path foretells the next one: it is drawn
/// anew, which is said, and p is that of a curve.
#[test]
fn a_parameter_that_wanders_goes_another_way() {
    let path = |t: f64| {
        let known = [1.0, 1.12, 1.2, 1.08, 0.9, 0.85, 1.0, 1.15, 1.22, 1.18, 1.2];
        let place = t / 100.0;
        let i = (0..9).rev().find(|i| f64::from(u8::try_from(*i).unwrap()) <= place).unwrap_or(0);
        let share = place - i as f64;
        known[i] + share * (known[i + 1] - known[i])
    };
    let found = diagnosed(|t| [0.0, path(t), 0.0]);
    let first = &found.causes[0];
    assert_eq!((found.verdict, first.label), (Verdict::Cause, "parameter-wander"));
    assert_eq!(first.site.name(), Some("loss"));
    assert!(found.held_out[0].is_redrawn && first.probability <= 0.75 + 1e-9, "{first:?}");
    assert!(0.8 < closes(&found), "{}", closes(&found));
}
