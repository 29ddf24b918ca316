//! The logs of a real micro gas turbine.

use std::path::PathBuf;

use fd_model::ResamplePolicy;

use crate::{LogMap, read_log};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

#[test]
#[ignore = "needs the logs of ../shared/data"]
fn logs_of_the_micro_gas_turbine_are_read_and_resampled() {
    let map = format!("{ROOT}/examples/micro-gas-turbine/columns.toml");
    let map: LogMap = toml::from_str(&std::fs::read_to_string(map).unwrap()).unwrap();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/micro_gas_turbine");
    let folder = PathBuf::from(folder);
    assert!(folder.is_dir(), "the logs are missing: no folder {}", folder.display());
    // Numbers of rows from the README of the data.
    for (run, rows) in [
        (1, 9920),
        (4, 9795),
        (9, 11819),
        (20, 6495),
        (21, 6495),
        (22, 8490),
        (23, 9188),
        (24, 9023),
    ] {
        let path = folder.join(format!("mgt_ex_{run}.csv"));
        let log = read_log(&path, &map).unwrap();
        let base = &log.time_base;
        println!(
            "run {run}: {} rows, step {:.4} s (median {:.4}, {:.4} to {:.4}), jitter {:.3} s, \
             {} gaps, even {}, {} samples, {} complete",
            base.rows,
            base.step_s,
            base.median_step_s,
            base.shortest_step_s,
            base.longest_step_s,
            base.jitter_s,
            base.gaps.len(),
            base.even,
            base.samples,
            log.record.missing().complete,
        );
        assert_eq!(base.rows, rows);
        // "About 1 s", says the README, and steps up to 4.3 s, below the five that are bridged.
        assert!((0.9..1.3).contains(&base.median_step_s));
        assert!(base.longest_step_s < 4.5);
        assert_eq!(log.record.missing().complete, log.record.len());
        for (u, y) in log.record.samples() {
            assert!((3.0..=10.0).contains(&u[0]) && (900.0..3400.0).contains(&y[0]));
        }
        // Without a policy of its own, the step of the file is found.
        let found = LogMap { resample: ResamplePolicy::default(), ..map.clone() };
        let found = read_log(&path, &found).unwrap();
        assert!((found.time_base.step_s - base.median_step_s).abs() < 1e-3);
        assert_eq!(found.record.missing().complete, found.record.len());
    }
}
