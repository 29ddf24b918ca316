//! A study of a user's logs: generated ones with a known answer, and those of a real gas turbine.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
};

use crate::support::{
    input,
    physical::{self, MODEL},
};
use fdiag::Watcher;
use fdiag::{
    compensate::decide::Isolation,
    core::Limits,
    ident::{arx::ArxOrders, order::Criterion},
    log::write_log,
    model::{
        Record,
        fault::{FaultProfile, FaultSpec, Site},
    },
    spec::{DetectorSpec, FaultSites, IsolationSpec, LearningSpec, OrderSpec, PipelineSpec},
};
use fdiag_cli::logs::{LogStudy, Request};

fn log(samples: usize, variant: u32) -> Record {
    physical::log(&input(samples, variant), u64::from(variant))
}

fn request(folder: &Path, logs: &[&str]) -> Request {
    let mut spec = PipelineSpec::default();
    spec.bias.orders = OrderSpec::Select { most: 4, criterion: Criterion::Bic, offset: false };
    // 60 s of healthy data do not show the largest residual that there will ever be.
    spec.detector = DetectorSpec::Maximum { margin: 0.5 };
    Request {
        model: folder.join("model.toml"),
        healthy: vec![folder.join("healthy.csv")],
        logs: logs.iter().map(|name| folder.join(name)).collect(),
        columns: None,
        spec,
        share_to_learn: 0.7,
        limits: Limits::default(),
    }
}

/// Counts what is still to be done.
#[derive(Default)]
struct Count(AtomicU64);

impl Watcher for Count {
    fn begin(&self, pieces: u64, done: u64) {
        assert_eq!((pieces, done), (3, 0));
        self.0.store(pieces, Ordering::Relaxed);
    }

    fn advance(&self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// The alarm comes in the faulty log, after the fault, in the right direction of time only; and
/// without compensation the same fault is not found.
#[test]
fn a_sensor_fault_is_found_where_it_is() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("model.toml"), MODEL).unwrap();
    write_log(folder.path().join("healthy.csv"), &log(2000, 0)).unwrap();
    write_log(folder.path().join("quiet.csv"), &log(1000, 4)).unwrap();
    let mut faulty = log(1000, 5);
    // 1 K of 50: far below what the model error does to the residual.
    let drift = FaultProfile::incipient(1.0, 5.0);
    FaultSpec::add(Site::sensor("temperature"), 40.0, drift).apply_to_record(&mut faulty).unwrap();
    write_log(folder.path().join("faulty.csv"), &faulty).unwrap();

    let counted = Count::default();
    let request = request(folder.path(), &["quiet.csv", "faulty.csv"]);
    let (study, traces) = LogStudy::run(&request.read().unwrap(), &counted).unwrap();
    println!("{}", study.headline());
    assert_eq!((counted.0.into_inner(), study.logs.len()), (0, 3));
    let [healthy, quiet, faulty] = &study.logs[..] else { panic!("three logs") };
    assert!(healthy.healthy && !quiet.healthy && !faulty.healthy);
    assert_eq!(healthy.first_alarm_s.1, None);
    assert_eq!(quiet.first_alarm_s, (None, None));
    let (without, with) = faulty.first_alarm_s;
    assert_eq!(without, None);
    // The ramp is 5 s long, the rule wants three samples in a row.
    assert!(with.is_some_and(|t| (40.0..45.5).contains(&t)), "{with:?}");
    // Compensation removes most of the residual of a log that it was not trained on.
    for (before, after) in quiet.rms_primary.iter().zip(&quiet.rms_compensated) {
        assert!(before / after > 5.0, "{before} {after}");
    }
    assert!(study.page(&traces).unwrap().to_html().contains("faulty.csv"));

    // The report survives JSON, and running again gives the same.
    let text = serde_json::to_string(&study).unwrap();
    assert_eq!(serde_json::from_str::<LogStudy>(&text).unwrap(), study);
    assert_eq!(LogStudy::run(&request.read().unwrap(), &()).unwrap().0, study);

    // Nothing is named unless it was asked for; then with how sure and how large, in K.
    assert_eq!(faulty.named, None);
    let faults = FaultSites::Both;
    let isolation = IsolationSpec::Bayes { faults, settings: Isolation::default() };
    let asked = Request { spec: PipelineSpec { isolation, ..request.spec.clone() }, ..request };
    let (study, traces) = LogStudy::run(&asked.read().unwrap(), &()).unwrap();
    assert_eq!((&study.logs[0].named, &study.logs[1].named), (&None, &None));
    let named = study.logs[2].named.as_ref().unwrap();
    assert_eq!((named.name.as_deref(), named.unit.as_str()), (Some("sensor temperature"), "K"));
    assert!(named.confidence.is_some_and(|p| (0.5..=1.0).contains(&p)), "{named:?}");
    let [low, high] = named.size_interval.unwrap();
    // The bias that is left is a few hundredths of the fault.
    assert!(low < high && low < 1.1 && high > 0.9, "{named:?}");
    assert!(named.size.is_some_and(|size| (size - 1.0).abs() < 0.2), "{named:?}");
    let page = study.page(&traces).unwrap().to_html();
    assert!(page.contains("Which fault it is") && page.contains("sensor temperature"));
}

/// A continuous model has no time base of its own: that of the first log counts, and the others are
/// brought onto it.
#[test]
fn all_logs_share_the_time_base_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let model = MODEL.replace("sample_time = 0.1\n", "").replace(
        "A = [[0.90, 0.06], [-0.04, 0.83]]\nB = [[0.06], [0.11]]",
        "A = [[-1.0, 0.6], [-0.4, -1.8]]\nB = [[0.6], [1.1]]",
    );
    std::fs::write(folder.path().join("model.toml"), model).unwrap();
    write_log(folder.path().join("healthy.csv"), &log(2000, 0)).unwrap();
    write_log(folder.path().join("slow.csv"), &log(2000, 1).decimated(2).unwrap()).unwrap();
    let (study, _) =
        LogStudy::run(&request(folder.path(), &["slow.csv"]).read().unwrap(), &()).unwrap();
    let slow = &study.logs[1];
    assert_eq!((slow.time_base.rows, slow.samples), (1000, 1999));
    assert!((slow.time_base.step_s - 0.1).abs() < 1e-12);
}

/// A crude first-order model of a real 3 kW gas turbine: train on its training runs, look at its test
/// runs.
///
/// What the model misses is a slew-rate limit, which no linear bias model has: learned from the steps
/// of the training runs, it helps on the steps of run 4 and harms on the small random input of run 22,
/// to which the turbine answers faster. Measured: 441 W to about 154 W, and 200 W to about 504 W.
#[test]
#[ignore = "needs the logs of ../shared/data"]
fn a_real_gas_turbine() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let data = root.join("../shared/data/micro_gas_turbine");
    assert!(data.is_dir(), "the logs are missing: no folder {}", data.display());
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("model.toml");
    let text = r#"
        version = 1
        kind = "state-space"
        name = "3 kW micro gas turbine: 270 W/V, 20 s"
        inputs = [{ name = "voltage", unit = "V", operating_point = 6.0 }]
        outputs = [{ name = "power", unit = "W", operating_point = 2000.0, scale = 1000.0 }]
        matrices = { A = [[-0.05]], B = [[0.0135]], C = [[1.0]] }
    "#;
    std::fs::write(&model, text).unwrap();
    let map =
        std::fs::read_to_string(root.join("examples/micro-gas-turbine/columns.toml")).unwrap();
    let run = |i: u32| data.join(format!("mgt_ex_{i}.csv"));
    let mut spec = PipelineSpec { hold_missing: 60, ..PipelineSpec::default() };
    spec.bias.orders = OrderSpec::Fixed(ArxOrders::paper(3).with_offset());
    spec.bias.learning = LearningSpec::Batch { prefilter_rad_s: Some(0.05) };
    let request = Request {
        model,
        healthy: [1, 9, 20, 21, 23, 24].map(run).to_vec(),
        logs: [4, 22].map(run).to_vec(),
        columns: Some(toml::from_str(&map).unwrap()),
        spec,
        share_to_learn: 0.7,
        limits: Limits::default(),
    };
    let (study, _) = LogStudy::run(&request.read().unwrap(), &()).unwrap();
    println!("{}", study.headline());
    assert_eq!(study.logs.len(), 8);
    for log in &study.logs {
        let (before, after) = (1000.0 * log.rms_primary[0], 1000.0 * log.rms_compensated[0]);
        println!(
            "{}: rms {before:.0} W before, {after:.0} W after; refused {}, alarm {:?}, in alarm {:?}",
            log.file.display(),
            log.refused,
            log.first_alarm_s,
            log.alarm_share
        );
        assert!(before.is_finite() && after.is_finite() && log.samples > 6000);
    }
    // Four of the eight runs have steps of up to 4.3 s on a base of 1 s.
    assert!(study.logs.iter().filter(|log| !log.time_base.even).count() >= 4);
    let [.., run_4, run_22] = &study.logs[..] else { panic!("eight logs") };
    assert!(run_4.rms_compensated[0] < 0.5 * run_4.rms_primary[0]);
    // The limit of the method, kept in sight: when this fails, something got better.
    assert!(run_22.rms_compensated[0] > run_22.rms_primary[0]);
    assert!(study.bias.poles[0].iter().all(|&radius| radius < 1.0));
}
