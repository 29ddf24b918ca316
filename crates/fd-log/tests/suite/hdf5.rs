//! HDF5 as h5py writes it, and as nobody should.

#![cfg(feature = "hdf5")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::path::PathBuf;

use fd_log::{LogError, LogMap, info, read_log};
use proptest::prelude::*;

fn data(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data")).join(name)
}

fn map(text: &str) -> LogMap {
    toml::from_str(text).unwrap()
}

#[test]
fn every_kind_of_number_is_read_as_h5py_wrote_it() {
    let map = map("inputs = [{ name = 'u', column = 'run/u' }]\n\
         outputs = [{ name = 'first', column = 'run/q[0]' }, { name = 'second', column = 'run/q[1]', unit = 'deg' }, \
         { name = 'half', column = 'run/half' }, { name = 'on', column = 'run/on' }, \
         { name = 'at', column = 'run/record.at' }, { name = 'code', column = 'run/record.code' }]");
    let log = read_log(data("run.h5"), &map).unwrap().record;
    assert_eq!((log.len(), log.outputs()[0].unit.as_str()), (40, "rad"));
    // The mean of rounded steps.
    assert!((log.ts().seconds() - 0.05).abs() < 1e-15);
    for k in 0..40 {
        let n = k as f64;
        assert_eq!(log.u(k), [(k % 7) as f64]);
        let y = log.y(k);
        let even = f64::from(u8::from(k % 2 == 0));
        // A unit that is converted rounds once.
        assert!((y[1] - (-n / 8.0).to_degrees()).abs() <= 1e-12 * (1.0 + n), "{k}");
        assert_eq!((&y[..1], &y[2..]), (&[n / 4.0][..], &[n / 4.0, even, n / 2.0, n][..]));
    }
}

#[test]
fn the_newest_layout_of_the_library_is_read() {
    let log = read_log(data("latest.h5"), &map("outputs = [{ name = 'y' }]")).unwrap().record;
    assert_eq!((log.len(), log.y(39)), (40, &[39.0 / 4.0][..]));
}

#[test]
fn matlab_writes_its_matrices_transposed() {
    let map = map("time = { column = 't' }\ninputs = [{ name = 'u', column = 'log.u' }]\n\
         outputs = [{ name = 'a', column = 'log.q[0]' }, { name = 'b', column = 'log.q[1]' }]");
    let log = read_log(data("matlab73.mat"), &map).unwrap().record;
    assert_eq!(log.len(), 40);
    for k in 0..40 {
        let n = k as f64;
        assert_eq!((log.u(k), log.y(k)), (&[(k % 7) as f64][..], &[n / 4.0, -n / 8.0][..]));
    }
}

#[test]
fn what_is_in_a_file_is_said() {
    let found = info(data("run.h5"), &LogMap::default()).unwrap();
    let rows: Vec<usize> = found.tables.iter().map(|table| table.rows).collect();
    // Datasets come in the order of their names.
    assert_eq!((found.format.as_str(), rows), ("HDF5", vec![5, 40]));
    let left = |name: &str| found.left.iter().find(|(known, _)| known == name).unwrap().1.clone();
    assert_eq!(left("dt"), "a single value");
    assert_eq!(left("name"), "something else than numbers");
    assert_eq!(left("cube"), "an array of 4 x 2 x 2");
    let error = read_log(data("run.h5"), &map("outputs = [{ name = 'name' }]")).unwrap_err();
    assert!(matches!(error, LogError::Unfit { .. }), "{error}");
}

/// Bytes that are read as a log of this name.
fn read(name: &str, bytes: &[u8]) -> Result<fd_log::Log, LogError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_log(&path, &map("outputs = [{ name = 'y' }]"))
}

#[test]
fn a_file_that_is_cut_off_is_damaged() {
    let whole = std::fs::read(data("latest.h5")).unwrap();
    for length in (16..whole.len()).step_by(97) {
        let error = read("cut.h5", &whole[..length]).unwrap_err();
        assert!(matches!(error, LogError::Damaged { format: "HDF5", .. }), "{length}: {error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// A flipped byte is an error or another number, and never the end of the program.
    #[test]
    fn a_flipped_byte_does_not_stop_the_program(at in 8_usize..3000, mask in 1_u8..) {
        for name in ["latest.h5", "run.h5", "matlab73.mat"] {
            let mut bytes = std::fs::read(data(name)).unwrap();
            let at = at % bytes.len();
            bytes[at] ^= mask;
            drop(read(name, &bytes));
        }
    }
}
