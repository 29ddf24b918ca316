//! Files of other kinds are named for what they are, with the way out.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

use fd_log::{LogError, LogMap, read_log};

fn said(name: &str, bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let map: LogMap = toml::from_str("outputs = [{ name = 'y' }]").unwrap();
    let error = read_log(&path, &map).unwrap_err();
    assert!(matches!(error, LogError::NoLog { expected: "a log", .. }), "{name}: {error}");
    error.to_string()
}

/// An archive with empty members of these names, as zip stores them.
fn archive(names: &[&str]) -> Vec<u8> {
    let (mut members, mut directory) = (Vec::new(), Vec::new());
    for name in names {
        let length = u16::try_from(name.len()).unwrap().to_le_bytes();
        let begin = u32::try_from(members.len()).unwrap().to_le_bytes();
        let common = [&[20, 0][..], &[0; 20], &length, &[0; 2]].concat();
        members.extend([b"PK\x03\x04", common.as_slice(), name.as_bytes()].concat());
        let about = [b"PK\x01\x02", &[20, 0][..], &common, &[0; 10], &begin, name.as_bytes()];
        directory.extend(about.concat());
    }
    let count = u16::try_from(names.len()).unwrap().to_le_bytes();
    let size = u32::try_from(directory.len()).unwrap().to_le_bytes();
    let begin = u32::try_from(members.len()).unwrap().to_le_bytes();
    let end = [b"PK\x05\x06", &[0; 4][..], &count, &count, &size, &begin, &[0; 2]].concat();
    [members, directory, end].concat()
}

#[test]
fn each_has_its_name_and_its_way_out() {
    for (name, bytes, what, way_out) in [
        ("run.bag", &b"#ROSBAG V2.0\n"[..], "a recording of ROS 1", "rosbags-convert"),
        ("run.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "old Office", "as CSV"),
        ("run.tdms", b"TDSm\x0e\0\0\0", "TDMS of LabVIEW", "npTDMS"),
        ("run.mf4", b"MDF     4.10    ", "MDF", "asammdf"),
        ("run.feather", b"ARROW1\0\0", "Arrow", "Parquet"),
        ("run.pkl", b"\x80\x04\x95", "a pickle", "numpy.savez"),
    ] {
        let said = said(name, bytes);
        assert!(said.contains(what) && said.contains(way_out), "{said}");
    }
}

#[test]
#[cfg(feature = "npz")]
fn archives_are_known_by_what_is_in_them() {
    for (name, members, what, way_out) in [
        ("model.pt", &["model/data.pkl", "model/data/0"][..], "a file of PyTorch", "numpy.savez"),
        ("run.zip", &["[Content_Types].xml", "xl/workbook.xml"], "a workbook of Excel", "as CSV"),
        ("plant.fmu", &["modelDescription.xml"], "an FMU", "that is a model"),
    ] {
        let said = said(name, &archive(members));
        assert!(said.contains(what) && said.contains(way_out), "{said}");
    }
}
