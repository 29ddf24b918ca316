//! MAT-files of version 5, as scipy writes them, and as nobody should.

#![cfg(feature = "mat")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::path::PathBuf;

use fd_log::{LogError, LogMap, info, read_log};
use proptest::prelude::*;

fn data(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data")).join(name)
}

fn map() -> LogMap {
    toml::from_str(
        "time = { column = 't' }\ninputs = [{ name = 'u', column = 'log.u' }]\n\
         outputs = [{ name = 'a', column = 'log.deep.q[0]' }, { name = 'b', column = 'log.deep.q[1]' }, { name = 'on' }]",
    )
    .unwrap()
}

#[test]
fn vectors_matrices_and_structs_are_read_as_scipy_wrote_them() {
    for name in ["plain.mat", "packed.mat"] {
        let log = read_log(data(name), &map()).unwrap().record;
        assert_eq!(log.len(), 40, "{name}");
        for k in 0..40 {
            let n = k as f64;
            let even = f64::from(u8::from(k % 2 == 0));
            assert_eq!(log.u(k), [(k % 7) as f64]);
            assert_eq!(log.y(k), [n / 4.0, -n / 8.0, even], "{name} {k}");
        }
    }
}

#[test]
fn what_is_no_column_is_named() {
    let found = info(data("plain.mat"), &LogMap::default()).unwrap();
    let rows: Vec<usize> = found.tables.iter().map(|table| table.rows).collect();
    assert_eq!((found.format.as_str(), rows), ("MAT", vec![40, 5]));
    for (name, why) in
        [("dt", "a single value"), ("name", "text"), ("z", "complex numbers"), ("cells", "cells")]
    {
        assert!(
            found.left.contains(&(name.to_owned(), why.to_owned())),
            "{name}: {:?}",
            found.left
        );
    }
}

/// Bytes that are read as a log.
fn read(bytes: &[u8]) -> Result<fd_log::Log, LogError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mat");
    std::fs::write(&path, bytes).unwrap();
    read_log(&path, &map())
}

#[test]
fn a_file_that_is_cut_off_never_gives_other_numbers() {
    for name in ["plain.mat", "packed.mat"] {
        let whole = std::fs::read(data(name)).unwrap();
        let expected = read(&whole).unwrap();
        for length in 16..whole.len() {
            // Behind the last array that is asked for the end of the file does not matter.
            match read(&whole[..length]) {
                Ok(log) => assert_eq!(log, expected, "{name} {length}"),
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
        assert!(matches!(read(&whole[..700]), Err(LogError::Damaged { format: "MAT", .. })));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A flipped byte is an error or another number, and never the end of the program.
    #[test]
    fn a_flipped_byte_does_not_stop_the_program(at in 100_usize..4000, mask in 1_u8..) {
        for name in ["plain.mat", "packed.mat"] {
            let mut bytes = std::fs::read(data(name)).unwrap();
            let at = at % bytes.len();
            bytes[at] ^= mask;
            drop(read(&bytes));
        }
    }
}
