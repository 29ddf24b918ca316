//! Several causes, one after another.

use fd_effect::{EverySite, library};
use fd_gap::{
    diagnose::{Case, Regime, Settings, diagnose},
    road::{End, road},
};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::{model::Model, scales::ReplayScales};

/// A lag with a well known time constant.
const MODEL: &str = r#"
version = 1
kind = "equations"
name = "lag"
sample_time = 0.1
parameters = { T = { unit = "s", value = 0.5, tolerance = 0.01 } }
inputs = { u = { unit = "V" } }
states = { x = { unit = "V", initial = 0.0, derivative = "(u - x)/T" } }
outputs = { y = { unit = "V", value = "x", noise = 0.002 } }
"#;

const SAMPLES: usize = 700;

/// Reality: a dead zone of 0.4 V, an end at 1.1 V, and a sensor that lags by 0.4 s. Steps of the command are
/// held over a sample, so that both lags are exact.
fn reality(model: &Model, seed: u64) -> Record {
    let noise = WhiteNoise::new(0.002, seed).values(SAMPLES).unwrap();
    let command = |k: usize| {
        let t = k as f64 + 1000.0 * seed as f64;
        1.3 * (0.031 * t).sin() + 0.7 * (0.13 * t).sin() + 0.3 * (0.41 * t).cos()
    };
    let (mut x, mut seen) = (0.0_f64, 0.0_f64);
    let rows = (0..SAMPLES).map(|k| {
        let u = command(k);
        let y = seen + noise[k];
        let acts = (u - u.clamp(-0.4, 0.4)).clamp(-1.1, 1.1);
        // Ten Euler steps: the sensor follows what moves within the sample.
        for _ in 0..100 {
            seen += 0.001 * (x - seen) / 0.4;
            x += 0.001 * (acts - x) / 0.5;
        }
        ([u], [y])
    });
    let rows: Vec<([f64; 1], [f64; 1])> = rows.collect();
    let (inputs, outputs) = (model.external_inputs(), model.output_channels());
    Record::from_rows(inputs, outputs, rows, model.sample_time().unwrap()).unwrap()
}

#[test]
fn causes_come_one_after_another_with_shares_that_add_up() {
    let model: Model = MODEL.parse().unwrap();
    let (fitted, held_out) = (reality(&model, 1), reality(&model, 2));
    let ts = model.sample_time().unwrap();
    let u: Vec<f64> = (0..SAMPLES).flat_map(|k| fitted.u(k).to_vec()).collect();
    let scales = ReplayScales::of(&model, ts, &u, SAMPLES).unwrap();
    let few = [
        "input-dead-zone",
        "input-saturation",
        "input-lag",
        "input-gain",
        "sensor-lag",
        "sensor-bias",
        "sensor-scale",
        "input-offset",
    ];
    let effects = library().into_iter().filter(|e| few.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, &model, scales);
    let (logs, held_out) = ([fitted], [held_out]);
    let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
    let settings = Settings::default();
    let first = diagnose(&case, &settings, &()).unwrap();
    assert_eq!(first.regime, Regime::AboveTheFloor, "two causes do not explain three");

    let found = road(&case, &first, &settings, 8, &()).unwrap().unwrap();
    let labels: Vec<&str> = found.causes.iter().map(|m| m.cause.label).collect();
    // Either lag is the lag of this loop-free chain; the dead zone and the end are one place each.
    for planted in ["input-dead-zone", "input-saturation"] {
        assert!(labels.contains(&planted), "{labels:?}");
    }
    assert!(labels.iter().any(|label| label.ends_with("-lag")), "{labels:?}");
    let shares: f64 = found.causes.iter().filter_map(|m| m.share).sum();
    assert!((shares + found.unexplained + found.noise - 1.0).abs() < 1e-9);
    assert!(found.unexplained < 0.05, "{found:?}");
    assert!(0.95 < found.closed.unwrap().fraction);
    // What was found can be adjusted in the next study, and what the user knows keeps its tolerance.
    let adjustable = found.model.parameters.iter().filter(|p| 0.0 < p.tolerance).count();
    assert!(labels.len() < adjustable, "{:?}", found.model.parameters);
    assert_eq!(found.model.parameters[0].tolerance, 0.01);

    let short = road(&case, &first, &settings, 1, &()).unwrap().unwrap();
    assert_eq!((short.end, short.causes.len()), (End::Enough, 1));
}
