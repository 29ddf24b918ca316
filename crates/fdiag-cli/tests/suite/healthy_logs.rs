//! Healthy logs that are none, and thresholds that are void, are said in words.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::support::{
    input,
    physical::{MODEL, log},
};
use fdiag::{
    core::Limits,
    log::write_log,
    model::{
        Record,
        fault::{FaultProfile, FaultSpec, Site},
    },
    spec::{DetectorSpec, PipelineSpec},
    training::Doubt,
};
use fdiag_cli::logs::{LogStudy, Request, VoidReason};

fn study(healthy: &Record, later: &Record) -> LogStudy {
    let detector = DetectorSpec::Maximum { margin: 0.5 };
    study_with(PipelineSpec { detector, ..PipelineSpec::default() }, healthy, later)
}

fn study_with(spec: PipelineSpec, healthy: &Record, later: &Record) -> LogStudy {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("model.toml"), MODEL).unwrap();
    write_log(file("healthy.csv"), healthy).unwrap();
    write_log(file("later.csv"), later).unwrap();
    let request = Request {
        model: file("model.toml"),
        healthy: vec![file("healthy.csv")],
        logs: vec![file("later.csv")],
        columns: None,
        spec,
        share_to_learn: 0.7,
        limits: Limits::default(),
    };
    let (study, traces) = LogStudy::run(&request.read().unwrap(), &()).unwrap();
    let text = serde_json::to_string(&study).unwrap();
    assert_eq!(serde_json::from_str::<LogStudy>(&text).unwrap(), study);
    let page = study.page(&traces).unwrap().to_html();
    assert_eq!(page.contains("Doubts about the healthy logs"), !study.doubts.is_empty());
    study
}

#[test]
fn a_healthy_log_is_not_doubted() {
    let study = study(&log(&input(2000, 0), 0), &log(&input(1000, 4), 4));
    assert_eq!(study.doubts, []);
    assert!(study.logs.iter().all(|log| log.void.is_none()));
    assert!(!study.headline().contains("healthy.csv"), "{}", study.headline());
}

#[test]
fn a_fault_in_it_is_said() {
    let mut healthy = log(&input(2000, 0), 0);
    // 3 K of 50 at 120 s.
    FaultSpec::add(Site::sensor("temperature"), 120.0, FaultProfile::abrupt(3.0))
        .apply_to_record(&mut healthy)
        .unwrap();
    let study = study(&healthy, &log(&input(1000, 4), 4));
    let jump = study.doubts.iter().find_map(|doubt| match doubt.doubt {
        Doubt::Jump { residual: 1, at_s, .. } => Some(at_s),
        _ => None,
    });
    assert!(jump.is_some_and(|at| (at - 120.0).abs() < 3.0), "{:?}", study.doubts);
    let words = study.headline();
    assert!(words.contains("healthy.csv: the residual of temperature jumps by"), "{words}");
}

#[test]
fn a_drift_in_it_is_said() {
    let mut healthy = log(&input(2000, 0), 0);
    for k in 0..healthy.len() {
        healthy.y_mut(k)[0] += 10.0 * k as f64 / 2000.0;
    }
    let words = study(&healthy, &log(&input(1000, 4), 4)).headline();
    assert!(words.contains("the residual of speed drifts by"), "{words}");
}

#[test]
fn too_little_excitation_is_said() {
    // One tone, and next to nothing that keeps the fit from being singular.
    let little = |k: f64| 1e-3 * (k * k * 0.618).sin();
    let u: Vec<f64> =
        (0..2000).map(f64::from).map(|k| 0.4 * (0.05 * k).sin() + little(k)).collect();
    let study = study(&log(&u, 0), &log(&input(1000, 4), 4));
    let little = |doubt: &Doubt| matches!(doubt, Doubt::LittleExcitation { input: 0, ways: 2, .. });
    assert!(study.doubts.iter().any(|doubt| little(&doubt.doubt)), "{:?}", study.doubts);
    assert!(study.headline().contains("the input fuel moves in 2 independent ways"));
}

#[test]
fn a_threshold_outside_the_trained_range_is_void() {
    // 100 s within the range, then 50 s far above it, then back.
    let mut u = input(2000, 4);
    u[1000..1500].iter_mut().for_each(|u| *u += 1.5);
    let study = study(&log(&input(2000, 0), 0), &log(&u, 4));
    let void = study.logs[1].void.as_ref().unwrap();
    assert_eq!(void.reason, VoidReason::OperatingPoint);
    assert!((100.0..106.0).contains(&void.since_s), "{void:?}");
    assert!((0.2..0.3).contains(&void.share), "{void:?}");
    assert!(study.logs[0].void.is_none());
    let words = study.headline();
    assert!(words.contains("later.csv: from ") && words.contains("states no rate"), "{words}");
}

/// Too short for the operating point, which looks at levels; a threshold that follows the input has seen no such jump.
#[test]
fn a_threshold_is_void_while_the_input_moves_as_in_no_healthy_log() {
    let mut u = input(2000, 4);
    u[1000..1003].iter_mut().for_each(|u| *u += 3.0);
    let text = "calibration = { beyond = \"extrapolate\" }\n[detector]\nkind = \"adaptive-threshold\"\n\
                corners = 3\nslowest_samples = 50\nmemory_samples = 20\nvoid_margin = 1.0\n\
                false_alarms = { kind = \"per-sample\", rate = 0.01 }\n";
    let study = study_with(text.parse().unwrap(), &log(&input(2000, 0), 0), &log(&u, 4));
    let void = study.logs[1].void.as_ref().unwrap();
    assert_eq!(void.reason, VoidReason::InputMotion);
    assert!((99.9..100.3).contains(&void.since_s), "{void:?}");
    assert!((0.002..0.1).contains(&void.share), "{void:?}");
    assert!(study.headline().contains("move as in no healthy log"), "{}", study.headline());
}
