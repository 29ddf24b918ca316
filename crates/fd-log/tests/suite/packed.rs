//! Packed text: files that gzip and Zstandard wrote, and files that are not what they seem.

#![cfg(feature = "packed")]

use std::{io::Write, path::PathBuf};

use fd_log::{LogError, LogMap, read_log};
use fd_model::Channel;

fn data(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data")).join(name)
}

fn map() -> LogMap {
    LogMap::for_channels(&[Channel::new("u", "V")], &[Channel::new("y", "degC")])
}

#[test]
fn packed_logs_are_read_as_plain_ones() {
    for name in ["run.csv.gz", "run.ndjson.zst"] {
        let record = read_log(data(name), &map()).unwrap().record;
        assert_eq!((record.len(), record.ts().seconds()), (50, 0.1), "{name}");
        for k in 0..record.len() {
            let t = k as f64 / 10.0;
            // Sines of two libraries may differ in the last bit.
            assert!((record.u(k)[0] - t.sin()).abs() < 1e-15, "{name}");
            assert_eq!(record.y(k), [20.0 + k as f64 / 4.0], "{name}");
        }
    }
}

#[test]
fn the_first_bytes_count_and_not_the_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    std::fs::copy(data("run.csv.gz"), &path).unwrap();
    assert_eq!(read_log(&path, &map()).unwrap().record.len(), 50);
}

#[test]
fn rubbish_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let said = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let error = read_log(&path, &map()).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
        error
    };
    for name in ["run.csv.gz", "run.ndjson.zst"] {
        let whole = std::fs::read(data(name)).unwrap();
        assert!(matches!(said(name, b""), LogError::Empty { .. }));
        let text = said(name, b"t,u,y\n0,1,2\n").to_string();
        assert!(text.contains("found `t,u,y\\n0,1,2\\n` at its beginning"), "{text}");
        // Cut off anywhere it is an error, never a short log.
        for length in 5..whole.len() {
            // But behind a whole member or frame there is nothing to miss.
            let path = folder.path().join("cut");
            std::fs::write(&path, &whole[..length]).unwrap();
            if let Ok(log) = read_log(&path, &map()) {
                assert!(log.record.len() < 50, "{name} {length}");
            }
        }
        let cut = said(name, &whole[..whole.len() / 3]);
        assert!(matches!(cut, LogError::Damaged { .. }), "{cut}");
        // A bit that flips in the data is found by a checksum or makes nonsense.
        let mut flipped = whole.clone();
        flipped[60] ^= 0x10;
        assert!(!matches!(said(name, &flipped), LogError::Io { .. }));
    }
}

#[test]
fn an_endless_line_is_refused_early() {
    // 64 MiB of one character, packed a thousandfold.
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    for _ in 0..64 {
        packed.write_all(&vec![b'7'; 1 << 20]).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.csv.gz");
    std::fs::write(&path, packed.finish().unwrap()).unwrap();
    let error = read_log(&path, &map()).unwrap_err();
    assert!(error.to_string().contains("a line of more than 16777216 bytes"), "{error}");
}
