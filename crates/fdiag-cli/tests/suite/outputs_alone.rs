//! Logs whose columns are all measured: nothing drives the plant that anybody knows of, and there is no bias to learn.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use fdiag::{
    core::Limits,
    log::write_log,
    model::{Channel, Record, SampleTime},
};
use fdiag_cli::logs::{LogStudy, Request};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Names and units of what is measured; the matrices say nothing.
const MODEL: &str = r#"
version = 1
kind = "state-space"
name = "four sensors"
sample_time = 0.1
outputs = [{ name = "a" }, { name = "b" }, { name = "c" }, { name = "d" }]
matrices = { A = [[0.0]], B = [[]], C = [[0.0], [0.0], [0.0], [0.0]] }
"#;

/// Four readings of two signals that wander; from the middle on the second is wrong by so much.
fn log(seed: u64, fault: f64) -> Record {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    // The sum of twelve uniform numbers has the variance of one.
    let mut normal = || (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
    let (mut x, samples) = ([0.0; 2], 5000);
    let mut y = Vec::new();
    for k in 0..samples {
        x = x.map(|x| 0.9 * x + 0.4 * normal());
        let wrong = if k < samples / 2 { 0.0 } else { fault };
        let exact = [x[0], x[0] + 0.5 * x[1] + wrong, x[1], x[0] - x[1]];
        y.extend(exact.map(|y| y + 0.1 * normal()));
    }
    let outputs = ["a", "b", "c", "d"].map(|name| Channel::new(name, "1"));
    Record::new(Vec::new(), outputs.to_vec(), Vec::new(), y, SampleTime::new(0.1).unwrap()).unwrap()
}

fn study(generator: &str) -> LogStudy {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("model.toml"), MODEL).unwrap();
    for (name, seed, fault) in
        [("healthy.csv", 1, 0.0), ("fresh.csv", 2, 0.0), ("faulty.csv", 3, 0.5)]
    {
        write_log(file(name), &log(seed, fault)).unwrap();
    }
    let spec = format!(
        "settle_s = 2.0\nbias.apply = \"never\"\ngenerator = {generator}\n\
         detector = {{ kind = \"chi-square\", window = 10, false_alarms = {{ kind = \"per-run\", probability = 0.01, samples = 4000 }} }}\n\
         calibration.beyond = \"extrapolate\""
    );
    let request = Request {
        model: file("model.toml"),
        healthy: vec![file("healthy.csv")],
        logs: vec![file("fresh.csv"), file("faulty.csv")],
        columns: None,
        spec: spec.parse().unwrap(),
        share_to_learn: 0.7,
        limits: Limits::default(),
    };
    LogStudy::run(&request.read().unwrap(), &()).unwrap().0
}

#[test]
fn a_wrong_sensor_is_found_among_the_others() {
    for generator in [
        r#"{ kind = "pca", lags = 1, components = { kind = "variance", share = 0.9 } }"#,
        r#"{ kind = "cva", past = 3, future = 3, states = 2 }"#,
    ] {
        let study = study(generator);
        let [_, fresh, faulty] = &study.logs[..] else { panic!("{study:?}") };
        assert_eq!(fresh.alarms_s, Vec::<[f64; 2]>::new(), "{generator}");
        let first = faulty.alarms_s.first().unwrap();
        assert!((250.0..252.0).contains(&first[0]), "{generator}: {first:?}");
        assert_eq!(faulty.first_alarm_s.1, Some(first[0]));
    }
}
