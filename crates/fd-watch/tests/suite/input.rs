//! Lines of all kinds: what is read, and what is said of the rest.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::common::*;
use fd_watch::{Format, RowReader, What};

fn reader(format: Format) -> RowReader {
    RowReader::new(format, input().with_units("rig"))
}

fn bad(line: &str) -> String {
    let mut rows = reader(Format::Ndjson);
    assert!(!rows.read(line.as_bytes()).unwrap(), "{line}");
    match &rows.take_events()[..] {
        [What::Unreadable { line: 1, reason }] => reason.clone(),
        other => panic!("{line}: {other:?}"),
    }
}

#[test]
fn json_lines_are_rows() {
    let mut rows = reader(Format::Ndjson);
    let line =
        r#"{"rig":"a","time":1.5,"fuel":2,"speed [rpm]":3000.5,"temperature [degC]":626.85}"#;
    assert!(rows.read(line.as_bytes()).unwrap());
    let row = rows.row();
    assert_eq!((row.unit, row.time), ("a", 1.5));
    assert!((row.values[2] - 900.0).abs() < 1e-9 && row.values[..2] == [2.0, 3000.5]);
    // Numbers may be units, and units may look like numbers without being the same.
    let mut unit = |text: &str| {
        let line = format!(
            r#"{{"rig":{text},"time":1,"fuel":2,"speed [rpm]":"NaN","temperature [degC]":null}}"#
        );
        assert!(rows.read(line.as_bytes()).unwrap());
        rows.row().unit.to_owned()
    };
    assert_eq!([unit("7"), unit(r#""007""#), unit(r#""null""#)], ["7", "007", "null"]);
    assert!(rows.row().values[1..].iter().all(|v| v.is_nan()));
    assert!(rows.take_events().is_empty());
    assert!(
        !rows.read(b"\n").unwrap() && rows.take_events().is_empty(),
        "an empty line is nothing"
    );
}

#[test]
fn what_is_no_row_is_said() {
    for (line, reason) in [
        ("rubbish", "expected value"),
        ("[1]", "expected an object of columns"),
        (r#"{"rig":"a","time":1,"fuel":2"#, "EOF"),
        (r#"{"rig":"a","time":1} {"#, "trailing"),
        (r#"{"rig":"a","fuel":2,"speed":1,"temperature":1}"#, "it has no time"),
        (r#"{"rig":"a","time":null,"fuel":2}"#, "it has no time"),
        (r#"{"rig":"a","time":"noon","fuel":2}"#, "the time is no number: `noon`"),
        (r#"{"time":1,"fuel":2,"speed":1,"temperature":1}"#, "it names no unit"),
        (r#"{"rig":"","time":1}"#, "1 to 200 characters"),
        (r#"{"rig":1.5,"time":1}"#, "expected the name of a unit"),
        (r#"{"rig":"a","time":1,"fuel":2,"fuel":3}"#, "`fuel` is there twice"),
        (r#"{"rig":"a","time":1,"t":1}"#, "are both time"),
        (r#"{"rig":"a","time":1,"speed [K]":3}"#, "cannot be converted"),
    ] {
        let said = bad(line);
        assert!(said.contains(reason), "{line}: {said}");
    }
    let deep = format!(r#"{{"rig":{}"#, "[".repeat(100_000));
    assert!(bad(&deep).contains("expected the name of a unit"));
    assert!(bad(&"x".repeat(1_000_000)).len() < 300);
}

#[test]
fn columns_that_are_unknown_missing_or_no_numbers_are_said() {
    let mut rows = reader(Format::Ndjson);
    let line = r#"{"rig":"a","time":1,"fule":2,"speed":"fast","temperature":1e999}"#;
    // A number that is too large for JSON's reader makes the line unreadable; as text it is a cell.
    assert!(!rows.read(line.as_bytes()).unwrap());
    rows.take_events();
    let line =
        r#"{"rig":"a","time":1,"fule":2,"speed":"fast","temperature":"inf","more":{"a":[1]}}"#;
    assert!(rows.read(line.as_bytes()).unwrap());
    assert!(rows.row().values.iter().all(|v| v.is_nan()));
    let text = |what: &What| serde_json::to_string(what).unwrap();
    let told: Vec<String> = rows.take_events().iter().map(text).collect();
    assert_eq!(
        told,
        [
            r#"{"kind":"not-a-number","column":"speed","line":2,"text":"fast"}"#,
            r#"{"kind":"not-a-number","column":"temperature","line":2,"text":"inf"}"#,
            r#"{"kind":"unknown-column","column":"more","nearest":null}"#,
            r#"{"kind":"missing-column","column":"fuel","line":2}"#,
        ]
    );
    // Unknown columns are told once, a row of missing ones seldom.
    for _ in 0..8 {
        assert!(rows.read(line.as_bytes()).unwrap());
    }
    let told: Vec<What> = rows.take_events();
    assert!(
        !told
            .iter()
            .any(|what| matches!(what, What::UnknownColumn { .. } | What::MissingColumn { .. }))
    );
}

#[test]
fn csv_lines_are_rows_and_their_header_must_be_whole() {
    let mut rows = reader(Format::Csv);
    let read = |rows: &mut RowReader, line: &str| rows.read(line.as_bytes());
    assert!(!read(&mut rows, "\u{feff}# fdiag-log version=1 sample_time=0.1\n").unwrap());
    let header = "t [ms];rig;fuel;speed;temperature;note\r\n";
    assert!(!read(&mut rows, header).unwrap());
    assert!(read(&mut rows, "1500;\"a;b\";2;;900;x\r\n").unwrap());
    assert_eq!((rows.row().unit, rows.row().time), ("a;b", 1.5));
    assert!(rows.row().values[1].is_nan());
    assert!(!read(&mut rows, "1600;a;2;3000\n").unwrap());
    assert!(!read(&mut rows, "\"cut off\n").unwrap());
    assert!(!read(&mut rows, "t [ms];rig;fuel;speed;temperature;note\n").unwrap(), "again");
    let told = rows.take_events();
    assert!(
        matches!(
            &told[..],
            [
                What::UnknownColumn { .. },
                What::Unreadable { line: 4, .. },
                What::Unreadable { line: 5, .. },
            ]
        ),
        "{told:?}"
    );

    let refused = |header: &str| read(&mut reader(Format::Csv), header).unwrap_err().to_string();
    assert_eq!(
        refused("t,rig,fuell,speed,temperature"),
        "the header has no column for fuel; did you mean `fuell`?"
    );
    assert!(refused("rig,fuel,speed,temperature").contains("no column for time"));
    assert!(refused("t,fuel,speed,temperature").contains("no column for the unit"));
    assert!(refused("t,time,rig,fuel,speed,temperature").contains("are both time"));
    assert!(refused("t,rig,fuel [K],speed,temperature").contains("cannot be converted"));
}
