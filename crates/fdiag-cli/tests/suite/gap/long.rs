//! Logs that are too long to be fitted whole.

use std::fmt::Write;

use crate::gap::{
    desk::{Desk, stdout},
    random::Random,
};

/// Rows of the long log.
const ROWS: usize = 40_000;

/// The cart of the quick start with 0.4 N of dry friction, pushed by steps; `tacho` is the gain of its tacho row
/// by row.
fn log(tacho: impl Fn(usize) -> f64) -> String {
    const STEPS: u32 = 20;
    let (mut v, mut force, mut random) = (0.0_f64, 0.0, Random(12345));
    let mut text = "time [s],force [N],speed [m/s]\n".to_owned();
    for k in 0..ROWS {
        if k % 40 == 0 {
            force = 6.0 * (random.uniform() - 0.5);
        }
        let noise = 0.004 * random.normal();
        let (time, speed) = (k as f64 / 100.0, tacho(k) * v + noise);
        writeln!(text, "{time},{force},{speed}").unwrap();
        for _ in 0..STEPS {
            let drive = force - 1.5 * v;
            let rubs = if v == 0.0 { drive.clamp(-0.4, 0.4) } else { 0.4 * v.signum() };
            let next = v + (drive - rubs) / 1.2 * 0.01 / f64::from(STEPS);
            // It stands before it turns.
            v = if v * next < 0.0 { 0.0 } else { next };
        }
    }
    text
}

const FEW: [&str; 6] = ["--only", "friction", "--only", "input-delay", "--only", "sensor-gain"];

#[test]
fn stretches_tell_the_cause_and_all_rows_are_judged() {
    let desk = Desk::new();
    desk.put("long.csv", &log(|_| 1.0));
    let plain = ["--model", "model.toml", "--log", "long.csv", "--out", "out"];
    let output = desk.run(&[&plain[..], &FEW].concat());
    assert!(output.status.success(), "{output:?}");
    let text = stdout(&output);
    assert!(text.starts_with("Coulomb friction at rail ("), "{text}");
    let report = desk.report();
    let whole = &report["whole"];
    assert_eq!(whole["rows"], ROWS);
    let fitted = whole["fitted"].as_u64().unwrap();
    assert!((1_000..=10_000).contains(&fitted), "{whole}");
    // What was found on an eighth of the rows holds on all of them: the noise is left.
    let [refitted, explained] = ["refitted", "explained"].map(|key| whole[key].as_f64().unwrap());
    assert!(explained < 1.2 && 2.0 * explained < refitted, "{whole}");
    assert_eq!(whole["unlike_count"], whole["unlike"].as_array().unwrap().len());
    assert_eq!(whole["unlike_count"], 0, "{whole}");
}

/// Five seconds of seven minutes in which the tacho slips are named with their rows, and are not the answer.
#[test]
fn what_is_unlike_the_rest_is_named_with_its_rows() {
    let desk = Desk::new();
    let slips = 31_000..31_500;
    desk.put("long.csv", &log(|k| if slips.contains(&k) { 0.5 } else { 1.0 }));
    let plain = ["--model", "model.toml", "--log", "long.csv", "--out", "out"];
    let output = desk.run(&[&plain[..], &FEW].concat());
    assert!(output.status.success(), "{output:?}");
    let report = desk.report();
    let worst = &report["whole"]["unlike"][0]["rows"];
    let [from, to] = [0, 1].map(|i| usize::try_from(worst[i].as_u64().unwrap()).unwrap());
    assert!(from < slips.end && slips.start < to, "{}", report["whole"]);
    let next = report["next"].as_array().unwrap();
    let says = |step: &serde_json::Value| step.as_str().unwrap().contains(&format!("rows {from}"));
    assert!(next.iter().any(says), "{next:?}");
}
