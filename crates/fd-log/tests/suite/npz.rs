//! Arrays of numpy, as numpy wrote them, and as nobody should.

#![cfg(feature = "npz")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::path::PathBuf;

use fd_log::{LogError, LogMap, LogTable, read_log};

fn data(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data")).join(name)
}

fn map(text: &str) -> LogMap {
    toml::from_str(text).unwrap()
}

#[test]
fn every_kind_of_number_is_read_as_numpy_wrote_it() {
    let map = map("inputs = [{ name = 'u' }]\n\
         outputs = [{ name = 'first', column = 'q[0]' }, { name = 'second', column = 'q[1]' }, \
         { name = 'f', column = 'q_fortran[1]' }, { name = 'half' }, { name = 'big' }, { name = 'on' }, \
         { name = 'stamp', unit = 's' }]");
    for name in ["arrays.npz", "packed.npz"] {
        let record = read_log(data(name), &map).unwrap().record;
        assert_eq!(record.len(), 40, "{name}");
        // The mean of rounded steps.
        assert!((record.ts().seconds() - 0.05).abs() < 1e-15, "{name}");
        for k in 0..40 {
            let n = k as f64;
            assert_eq!(record.u(k), [(k % 7) as f64]);
            let even = f64::from(u8::from(k % 2 == 0));
            let y = record.y(k);
            assert_eq!(y[..6], [n / 4.0, -n / 8.0, -n / 8.0, n / 4.0, n * 1e6, even], "{name} {k}");
            // Whole nanoseconds times 1e-9: one rounding of each.
            assert!((y[6] - n * 0.05).abs() < 1e-15, "{name} {k}");
        }
    }
}

#[test]
fn a_date_can_be_the_time_and_one_array_a_log() {
    let stamped = map("outputs = [{ name = 'half' }]\ntime = { column = 'stamp' }");
    let ts = read_log(data("packed.npz"), &stamped).unwrap().record.ts().seconds();
    assert!((ts - 0.05).abs() < 1e-15);
    let rows = map("outputs = [{ name = 'x', column = 'arr[1]' }]\ntime = { sample_time = 0.1 }");
    let record = read_log(data("matrix.npy"), &rows).unwrap().record;
    assert_eq!((record.len(), record.y(8)), (40, &[-1.0][..]));
    let events = map("outputs = [{ name = 'at_s' }]\ntime = { sample_time = 1 }");
    assert_eq!(read_log(data("arrays.npz"), &events).unwrap().record.y(2), [1.0]);
}

#[test]
fn what_cannot_be_a_column_says_why() {
    let said = |output: &str| {
        let map = map(&format!("inputs = [{{ name = 'u' }}]\noutputs = [{{ name = '{output}' }}]"));
        read_log(data("arrays.npz"), &map).unwrap_err().to_string()
    };
    assert!(said("dt").ends_with("expected one number per row, found a single value"));
    assert!(said("cube").ends_with("found an array of shape [40, 2, 2]"));
    assert!(said("name").ends_with("found an array of type `<U3`"));
    assert!(
        said("slow").ends_with("expected 40 values, as in the others, found 5"),
        "{}",
        said("slow")
    );
    assert!(said("q").contains("there is no column `q`"));
}

/// A file with these bytes, read as a log.
fn read(name: &str, bytes: &[u8]) -> Result<fd_log::Log, LogError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_log(
        &path,
        &map("outputs = [{ name = 'x', column = 'arr[1]' }]\ntime = { sample_time = 0.1 }"),
    )
}

/// An array with this header and these bytes of data.
fn array(header: &str, data: &[u8]) -> Vec<u8> {
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), data].concat()
}

#[test]
fn rubbish_is_told() {
    for name in ["arrays.npz", "packed.npz", "matrix.npy"] {
        let whole = std::fs::read(data(name)).unwrap();
        assert!(matches!(read(name, b""), Err(LogError::Empty { .. })));
        assert!(matches!(read(name, b"t,u\n0,1\n"), Err(LogError::Damaged { .. })));
        for length in (1..whole.len()).step_by(97) {
            assert!(read(name, &whole[..length]).is_err(), "{name} {length}");
        }
        // Any byte changed: an error or other numbers, but no panic.
        for place in (0..whole.len()).step_by(41) {
            let mut changed = whole.clone();
            changed[place] ^= 0xff;
            drop(read(name, &changed));
        }
    }
}

#[test]
fn claims_of_size_are_not_believed() {
    let header =
        |shape: &str| format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    for shape in ["(1000000000000, 2)", "(18446744073709551615, 2)", "(9223372036854775808, 4)"] {
        let error = read("huge.npy", &array(&header(shape), &[0; 64])).unwrap_err();
        assert!(matches!(error, LogError::TooLarge { .. }), "{error}");
    }
    // Within what a log may have, but more than so short a file can stand for, however it is packed.
    let error = read("short.npy", &array(&header("(100000000, 2)"), &[0; 64])).unwrap_err();
    assert!(matches!(error, LogError::TooLarge { .. }), "{error}");
    // Within that as well, but not there.
    let error = read("short.npy", &array(&header("(1000000, 2)"), &[0; 64])).unwrap_err();
    assert!(error.to_string().ends_with("ends after 64 of 16000000 bytes"), "{error}");
    for wrong in ["", "{", "{'descr': '<f8'}", "{'descr': '<f8', 'shape': 5}"] {
        let error = read("wrong.npy", &array(wrong, &[0; 64])).unwrap_err();
        assert!(error.to_string().contains("a header that numpy does not write"), "{error}");
    }
}

#[test]
fn a_table_of_memory_is_unchanged() {
    let table = LogTable::new("run", [("t", vec![0.0, 1.0]), ("x", vec![5.0, 6.0])]).unwrap();
    assert_eq!(table.read(&map("outputs = [{ name = 'x' }]")).unwrap().record.y(1), [6.0]);
}
