//! The benchmark on line: what the paper's way must show there, on seeds that nothing was chosen on.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use fd_lab::engine::{Benchmark, EngineConfig, OnLineConfig, Study};

fn study(config: EngineConfig) -> Study {
    Benchmark::new(config).unwrap().study(&()).unwrap()
}

#[test]
fn on_line_the_switch_opens_and_faults_are_no_changes() {
    let config = EngineConfig { first_seed: 720_001, seeds: 12, ..EngineConfig::default() };
    let study = study(config);
    let line = study.summary.on_line.as_ref().unwrap();
    println!("{line:?}");
    assert!(line.opened.hits >= 10, "{:?}", line.opened);
    assert!(line.opened_s.low >= 12.0, "at least 200 samples and 50 of trial");
    assert!(line.fault_free_ratio.median > 5.0, "{:?}", line.fault_free_ratio);
    assert!(line.incipient_mistaken.hits <= 1, "{:?}", line.incipient_mistaken);
    assert!(line.healthy_changed.hits <= 1, "{:?}", line.healthy_changed);
    // 5 % of 12 are 0.6; four or more come by chance in one study of 500.
    assert!(line.healthy_alarm.hits <= 3, "{:?}", line.healthy_alarm);
    assert!(line.jumps_stated.hits <= 3, "{:?}", line.jumps_stated);
    // The jumps are beyond what the threshold was set on, and said to be.
    assert!(line.jumps_void > 0.01 && line.jumps_void < 0.2, "{}", line.jumps_void);
    assert!(line.healthy_void < line.jumps_void, "{}", line.healthy_void);
    // Raised for the seconds after a step, it finds what a constant one finds.
    assert!(line.faults.iter().all(|(found, _)| found.hits + 1 >= found.of), "{:?}", line.faults);
    assert!(line.faults[0].1.median < 10.0, "{:?}", line.faults[0]);
    assert!(line.drift_seen.hits * 2 > line.drift_seen.of, "{:?}", line.drift_seen);
    // Learned again, less is left than with the bias of the plant that was.
    assert!(
        line.drift_new.median < line.drift_old.median,
        "{:?} {:?}",
        line.drift_new,
        line.drift_old
    );
    assert_eq!(line.in_training.len(), study.config.on_line.faults.len());
    let titles: Vec<String> = study.tables().iter().map(|table| table.title.clone()).collect();
    assert!(titles.iter().any(|title| title.starts_with("On line:")), "{titles:?}");
}

/// The strongest constant threshold on all channels leaves less to be gained than `W r` does.
#[test]
fn the_fair_figure_is_smaller_than_the_paper_s() {
    let on_line = OnLineConfig { run: false, ..OnLineConfig::default() };
    let config =
        EngineConfig { first_seed: 730_001, seeds: 12, on_line, ..EngineConfig::default() };
    let study = study(config);
    assert!(study.summary.on_line.is_none() && study.trials.iter().all(|t| t.on_line.is_none()));
    for fault in &study.summary.faults {
        println!("{fault:?}");
        assert!(fault.fair_ratio.median < fault.smallest_ratio.median, "{fault:?}");
        assert!(fault.vector_primary.median < fault.smallest_primary.median, "{fault:?}");
    }
    assert!(study.headline().contains("best constant threshold"), "{}", study.headline());
}

/// Engines without a linear plant have no columns on line.
#[test]
fn nonlinear_engines_are_left_out() {
    let text = include_str!("../../../../examples/engine/nonlinear-mid.toml");
    let mut config: EngineConfig = text.parse().unwrap();
    (config.seeds, config.first_seed) = (1, 740_001);
    assert!(study(config).summary.on_line.is_none());
}
