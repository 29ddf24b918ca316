//! What is said of a log before it is used.

#![cfg(all(feature = "packed", feature = "npz", feature = "mcap", feature = "ulog"))]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::path::PathBuf;

use fd_log::{LogInfo, LogMap, info};

fn of(name: &str) -> LogInfo {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data"));
    info(folder.join(name), &LogMap::default()).unwrap()
}

#[test]
fn packed_text_is_described_as_what_is_in_it() {
    let found = of("run.csv.gz");
    assert_eq!((found.format.as_str(), found.tables.len()), ("CSV in gzip", 1));
    let table = &found.tables[0];
    let clock = table.clock.as_ref().unwrap();
    assert_eq!((table.rows, clock.column.as_str(), clock.is_even, clock.gaps), (50, "t", true, 0));
    assert_eq!(table.columns[2].unit.as_deref(), Some("degC"));
    assert_eq!((table.columns[2].least, table.columns[2].most), (20.0, 32.25));
    assert_eq!(found.doubts, Vec::<String>::new());
}

#[test]
fn every_clock_of_a_recording_is_measured() {
    let found = of("robot.mcap");
    // One of them in JSON.
    assert_eq!(found.tables.len(), 7);
    assert!(found.doubts[0].starts_with("7 clocks"), "{:?}", found.doubts);
    let imu = found.tables.iter().find(|table| table.name == "/imu").unwrap();
    let clock = imu.clock.as_ref().unwrap();
    // Nanoseconds times 1e-9.
    assert!((clock.median_step_s - 0.02).abs() < 1e-12 && clock.is_even && imu.rows == 50);
    let rate = imu.columns.iter().find(|column| column.name == "/imu.angular_velocity.x").unwrap();
    assert_eq!((rate.unit.as_deref(), rate.guess.as_deref()), (None, Some("rad/s")));
    assert!(found.left.contains(&("/say".to_owned(), "messages without numbers".to_owned())));
    assert_eq!(of("flight.ulg").tables.len(), 3);
}

#[test]
fn arrays_of_several_lengths_are_several_tables() {
    let found = of("arrays.npz");
    let rows: Vec<usize> = found.tables.iter().map(|table| table.rows).collect();
    assert_eq!(rows, [40, 5, 3]);
    assert!(found.left.iter().any(|(name, why)| name == "dt" && why == "a single value"));
    let matrix = of("matrix.npy");
    assert!(matrix.doubts[0].starts_with("no column is time"), "{:?}", matrix.doubts);
}

#[test]
fn text_that_is_read_wrongly_is_doubted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    std::fs::write(
        &path,
        "time;x;note\n1763899200000;1,500;a\n1763899200010;1,600;b\n1763899200090;;c\n",
    )
    .unwrap();
    let found = info(&path, &LogMap::default()).unwrap();
    let table = &found.tables[0];
    assert!(
        table
            .clock
            .as_ref()
            .unwrap()
            .doubts
            .iter()
            .any(|doubt| doubt.contains("time.unit = \"ms\""))
    );
    assert!(table.columns[1].doubts[0].contains("decimal_comma"), "{:?}", table.columns[1]);
    assert_eq!(
        (table.columns[1].texts, table.columns[1].missing, table.columns[2].texts),
        (2, 1, 3)
    );
}
