//! Parquet and `LeRobot` datasets, as pyarrow wrote them, and as nobody should.

#![cfg(feature = "parquet")]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]
#![allow(clippy::float_cmp, reason = "what is compared so was written exactly")]

use std::path::PathBuf;

use fd_log::{Log, LogError, LogMap, read_log};

fn data(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data")).join(name)
}

fn map(text: &str) -> LogMap {
    toml::from_str(text).unwrap()
}

fn table_map() -> LogMap {
    map("time = { column = 'stamp' }\ninputs = [{ name = 'u' }]\n\
         outputs = [{ name = 'y' }, { name = 'on' }, { name = 'ms' }, { name = 'a', column = 'q[0]' }, \
         { name = 'b', column = 'q[1]' }]")
}

#[test]
fn columns_times_and_lists_are_read() {
    for name in ["table.parquet", "table.zstd.parquet"] {
        let record = read_log(data(name), &table_map()).unwrap().record;
        assert_eq!(record.len(), 60, "{name}");
        // Whole nanoseconds times 1e-9.
        assert!((record.ts().seconds() - 0.02).abs() < 1e-15);
        for k in 0..60 {
            let n = k as f64;
            assert_eq!(record.u(k), [(k % 5) as f64]);
            let y = record.y(k);
            assert!(if k == 7 { y[0].is_nan() } else { y[0] == n / 3.0 }, "{name} {k}");
            assert_eq!((y[1], y[2], y[3]), (f64::from(u8::from(k % 2 == 0)), 20.0 * n, n));
            assert!(if k == 3 { y[4].is_nan() } else { y[4] == -n }, "{name} {k}");
        }
    }
    let said =
        read_log(data("table.parquet"), &map("outputs = [{ name = 'remark' }]")).unwrap_err();
    assert!(
        said.to_string().contains("expected one number per row, found values of type String"),
        "{said}"
    );
}

fn arm(rule: &str) -> LogMap {
    map(&format!(
        "inputs = [{{ name = 'command', column = 'action[shoulder_pan]' }}]\n\
         outputs = [{{ name = 'pan', column = 'observation.state[shoulder_pan]' }}]\n{rule}"
    ))
}

/// An episode has its own length, and its number in the command.
fn check(log: &Log, episode: usize) {
    let record = &log.record;
    assert_eq!((record.len(), record.ts().seconds()), (20 + episode, 1.0 / 30.0));
    assert_eq!(record.u(0), [episode as f64]);
    // Single precision, and sines of two libraries.
    assert!((record.y(9)[0] - (7.0_f64 / 4.0).sin()).abs() < 1e-7);
}

#[test]
fn an_episode_of_a_dataset_is_a_log() {
    for version in ["lerobot-v2.1", "lerobot-v3.0"] {
        for episode in 0..3 {
            let path = data(version).join(format!("episode_{episode}"));
            check(&read_log(path, &arm("")).unwrap(), episode);
            let rule = format!("rows = [{{ column = 'episode_index', equals = {episode} }}]");
            check(&read_log(data(version), &arm(&rule)).unwrap(), episode);
        }
        let all = read_log(data(version), &arm("")).unwrap_err().to_string();
        assert!(
            all.contains("DATASET/episode_0") && all.ends_with("a dataset of 3 episodes"),
            "{all}"
        );
        let none = read_log(data(version).join("episode_7"), &arm("")).unwrap_err().to_string();
        assert!(none.ends_with("found no episode 7 in its files"), "{none}");
    }
    let file = data("lerobot-v2.1/data/chunk-000/episode_000002.parquet");
    check(&read_log(file, &arm("")).unwrap(), 2);
}

#[test]
fn rubbish_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.parquet");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read_log(&path, &table_map())
    };
    for name in ["table.parquet", "table.zstd.parquet"] {
        let whole = std::fs::read(data(name)).unwrap();
        assert!(matches!(read(b""), Err(LogError::Empty { .. })));
        assert!(matches!(read(b"t,u\n0,1\n"), Err(LogError::Damaged { .. })));
        for length in (4..whole.len()).step_by(83) {
            assert!(
                matches!(read(&whole[..length]), Err(LogError::Damaged { .. })),
                "{name} {length}"
            );
        }
        // Any byte changed: an error or other numbers, but no panic.
        for place in (0..whole.len()).step_by(7) {
            let mut changed = whole.clone();
            changed[place] ^= 0xff;
            drop(read(&changed));
        }
    }
}
