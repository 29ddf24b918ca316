//! Several causes, one after another.

use fd_effect::{EverySite, library};
use fd_gap::{
    diagnose::{Case, Regime, Settings, diagnose},
    road::{End, ListedCause, road},
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

/// A dead zone, an end and the lag of a sensor that the model does not know, and noise.
#[derive(Clone, Copy)]
struct Real {
    dead_zone: f64,
    end: f64,
    lag: f64,
    noise: f64,
}

/// Far above the noise.
const LARGE: Real = Real { dead_zone: 0.4, end: 1.1, lag: 0.4, noise: 0.002 };

/// A log of inputs and outputs.
pub(crate) fn record<const I: usize, const O: usize>(
    model: &Model,
    rows: impl Iterator<Item = ([f64; I], [f64; O])>,
) -> Record {
    let rows: Vec<([f64; I], [f64; O])> = rows.collect();
    let (inputs, outputs) = (model.external_inputs(), model.output_channels());
    Record::from_rows(inputs, outputs, rows, model.sample_time().unwrap()).unwrap()
}

/// Steps of the command are held over a sample, so that both lags are exact.
fn reality(model: &Model, real: Real, seed: u64) -> Record {
    let noise = WhiteNoise::new(real.noise, seed).values(SAMPLES).unwrap();
    let command = |k: usize| {
        let t = k as f64 + 1000.0 * seed as f64;
        1.3 * (0.031 * t).sin() + 0.7 * (0.13 * t).sin() + 0.3 * (0.41 * t).cos()
    };
    let (mut x, mut seen) = (0.0_f64, 0.0_f64);
    let rows = (0..SAMPLES).map(|k| {
        let u = command(k);
        let y = seen + noise[k];
        let acts = (u - u.clamp(-real.dead_zone, real.dead_zone)).clamp(-real.end, real.end);
        // Ten Euler steps: the sensor follows what moves within the sample.
        for _ in 0..100 {
            seen += 0.001 * (x - seen) / real.lag;
            x += 0.001 * (acts - x) / 0.5;
        }
        ([u], [y])
    });
    record(model, rows)
}

/// A few effects that could be at work here.
const FEW: [&str; 8] = [
    "input-dead-zone",
    "input-saturation",
    "input-lag",
    "input-gain",
    "sensor-lag",
    "sensor-bias",
    "sensor-scale",
    "input-offset",
];

/// These effects wherever they can be, with scales of a log.
pub(crate) fn suspects<'a>(model: &'a Model, fitted: &Record, few: &[&str]) -> EverySite<'a> {
    let ts = model.sample_time().unwrap();
    let u: Vec<f64> = (0..fitted.len()).flat_map(|k| fitted.u(k).to_vec()).collect();
    let scales = ReplayScales::of(model, ts, &u, fitted.len()).unwrap();
    let effects = library().into_iter().filter(|e| few.contains(&e.label())).collect();
    EverySite::new(effects, model, scales)
}

/// Two causes come near the noise, so that evidence judges, and it asks for the third.
#[test]
fn near_the_noise_evidence_asks_for_a_third_cause() {
    let model: Model = MODEL.replace("noise = 0.002", "noise = 0.02").parse().unwrap();
    let small = Real { dead_zone: 0.3, end: 1.5, lag: 0.05, noise: 0.02 };
    let (fitted, held_out) = (reality(&model, small, 1), reality(&model, small, 2));
    let suspects = suspects(&model, &fitted, &FEW);
    let (logs, held_out) = ([fitted], [held_out]);
    let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
    let settings = Settings::default();
    let first = diagnose(&case, &settings, &()).unwrap();
    assert_eq!(first.regime, Regime::AtTheFloor);

    let found = road(&case, &first, &settings, 8, &()).unwrap().unwrap();
    let mut labels: Vec<&str> = found.causes.iter().map(|m| m.cause.label).collect();
    labels.sort_unstable();
    // Lags before and behind a lag are the same.
    assert!(labels[1].ends_with("-lag") || labels[2].ends_with("-lag"), "{labels:?}");
    labels.retain(|label| !label.ends_with("-lag"));
    assert_eq!(labels, ["input-dead-zone", "input-saturation"]);
    assert_eq!(found.end, End::AtTheNoise);
    // The largest first, each sought anew beside all others, and none that something else explains better by more than the
    // tenth of a nat to which evidence is known; that is divided by a temperature of 1.5.
    let evidence: Vec<f64> = found.causes.iter().map(|m| m.cause.log_evidence).collect();
    assert!(evidence.is_sorted_by(|a, b| b <= a) && 5.0 < evidence[2], "{evidence:?}");
    let odds: Vec<f64> = found.causes.iter().map(|m| m.odds).collect();
    assert!(odds.iter().all(|odds| (0.93..=1.0).contains(odds)), "{odds:?}");

    let short = road(&case, &first, &settings, 2, &()).unwrap();
    assert!(short.is_none(), "two causes are what the diagnosis has said: {short:?}");
}

#[test]
fn causes_come_one_after_another_with_shares_that_add_up() {
    let model: Model = MODEL.parse().unwrap();
    let (fitted, held_out) = (reality(&model, LARGE, 1), reality(&model, LARGE, 2));
    let suspects = suspects(&model, &fitted, &FEW);
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

/// Forecasts let a gain stand for the dead zone and the end, and nothing is believed beside it. But laws bring the held-out
/// log down to the noise as well.
#[test]
fn laws_that_explain_everything_are_found_beside_a_curve() {
    let model: Model = MODEL.parse().unwrap();
    let (fitted, held_out) = (reality(&model, LARGE, 1), reality(&model, LARGE, 2));
    let with_curve = [&FEW[..], &["input-map"]].concat();
    let suspects = suspects(&model, &fitted, &with_curve);
    let (logs, held_out) = ([fitted], [held_out]);
    let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
    let settings = Settings::default();
    let first = diagnose(&case, &settings, &()).unwrap();
    assert_eq!(first.regime, Regime::AboveTheFloor);

    let found = road(&case, &first, &settings, 8, &()).unwrap().unwrap();
    let labels: Vec<&str> = found.causes.iter().map(|m| m.cause.label).collect();
    assert_eq!((found.end, labels.len()), (End::AtTheNoise, 3), "{labels:?}");
    for planted in ["input-dead-zone", "input-saturation"] {
        assert!(labels.contains(&planted), "{labels:?}");
    }
    assert!(labels.iter().any(|label| label.ends_with("-lag")), "{labels:?}");
    assert!(found.unexplained < 0.02, "{found:?}");
}

/// Three lags of which each drive has a dead zone, and something that no law here is.
fn three_drives(model: &Model, seed: u64) -> Record {
    let noise = WhiteNoise::new(0.002, seed).values(3 * SAMPLES).unwrap();
    let mut x = [0.0_f64; 3];
    let rows = (0..SAMPLES).map(|k| {
        let t = k as f64 + 1000.0 * seed as f64;
        let u = [0.31, 0.23, 0.17].map(|w: f64| 1.3 * (0.1 * w * t).sin() + 0.7 * (w * t).cos());
        let y = [0, 1, 2].map(|i| x[i] + noise[3 * k + i]);
        for ((x, u), width) in x.iter_mut().zip(u).zip([0.4, 0.3, 0.35]) {
            let acts = u - u.clamp(-width, width) + 0.03 * (7.0 * *x).sin();
            *x = acts + (*x - acts) * (-0.2_f64).exp();
        }
        (u, y)
    });
    record(model, rows)
}

/// No dead zone explains half of the gap, and yet each is sure: it explains what the others leave.
#[test]
fn the_same_effect_in_three_places_is_found_in_all_of_them() {
    let three = ["a", "b", "c"];
    let each = |what: &dyn Fn(&str) -> String| three.map(what).join("\n");
    let model = format!(
        "version = 1\nkind = \"equations\"\nname = \"drives\"\nsample_time = 0.1\n[inputs]\n{}\n[states]\n{}\n[outputs]\n{}\n",
        each(&|i| format!("u{i} = {{ unit = \"V\" }}")),
        each(&|i| format!(
            "x{i} = {{ unit = \"V\", initial = 0.0, derivative = \"(u{i} - x{i})/0.5\" }}"
        )),
        each(&|i| format!("y{i} = {{ unit = \"V\", value = \"x{i}\", noise = 0.002 }}")),
    );
    let model: Model = model.parse().unwrap();
    let (fitted, held_out) = (three_drives(&model, 1), three_drives(&model, 2));
    let suspects = suspects(&model, &fitted, &FEW);
    let (logs, held_out) = ([fitted], [held_out]);
    let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
    let settings = Settings::default();
    let first = diagnose(&case, &settings, &()).unwrap();
    assert_eq!(first.regime, Regime::AboveTheFloor);
    assert!(first.causes[0].probability < 0.5, "one of three: {:?}", first.causes[0]);

    let found = road(&case, &first, &settings, 8, &()).unwrap().unwrap();
    let mut named: Vec<(&str, &str)> = found
        .causes
        .iter()
        .map(|ListedCause { cause, .. }| (cause.label, cause.site.name().unwrap_or_default()))
        .collect();
    named.sort_unstable();
    assert_eq!(named, ["ua", "ub", "uc"].map(|input| ("input-dead-zone", input)));
    assert!(found.causes.iter().all(|m| 0.8 < m.probability), "{:?}", found.causes);
    // Each as wide as it is, but for what the unknown part makes of it.
    for ListedCause { cause, .. } in &found.causes {
        let widths = [("ua", 0.4), ("ub", 0.3), ("uc", 0.35)];
        let truth = widths.iter().find(|(input, _)| Some(*input) == cause.site.name()).unwrap().1;
        let found = cause.parameters[0].value;
        assert!((found - truth).abs() < 0.05, "{found} for {truth}");
    }
}
