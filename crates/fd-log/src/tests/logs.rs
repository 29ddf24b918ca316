//! Reading and writing of logs.

use std::io;

use fd_model::{Channel, Disorder, Record, SampleTime, TimeBaseError, file::FileAction};
use proptest::prelude::*;

use crate::{
    ColumnMap, Log, LogError, LogMap, LogReader, TimeMap, open, read_log, read_log_from, write_log,
    write_log_to,
};

fn map() -> LogMap {
    LogMap::for_channels(&[Channel::new("wf", "kg/s")], &[Channel::new("T_7", "K")])
}

fn read(csv: &str) -> Result<Log, LogError> {
    read_log_from("run3.csv", csv.as_bytes(), &map())
}

fn message(csv: &str) -> String {
    read(csv).unwrap_err().to_string()
}

fn any_value() -> impl Strategy<Value = f64> {
    let finite =
        proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO;
    prop_oneof![8 => finite, 1 => Just(f64::NAN), 1 => -1.0..1.0_f64]
}

/// Any name or unit that a header can carry: quotes, separators and line breaks inside included.
fn any_name() -> impl Strategy<Value = String> {
    "[a-zA-Z_µ][a-z0-9 ,;\"'\t.#]{0,6}[a-z0-9]"
}

fn any_record() -> impl Strategy<Value = Record> {
    let names = proptest::collection::btree_set(any_name(), 1..5);
    (names, 1_usize..30, 0_usize..4, 1e-3..1e3_f64, -1e4..1e4_f64).prop_flat_map(
        |(names, n, inputs, ts, start)| {
            let names: Vec<String> = names.into_iter().filter(|n| n != "time").collect();
            let nu = inputs.min(names.len().saturating_sub(1));
            let ny = names.len() - nu;
            let values = |len| proptest::collection::vec(any_value(), len);
            (values(n * nu), values(n * ny)).prop_map(move |(u, y)| {
                let mut channels = names.iter().map(|name| Channel::new(name, "odd unit"));
                let inputs: Vec<Channel> = channels.by_ref().take(nu).collect();
                let ts = SampleTime::new(ts).unwrap();
                Record::new(inputs, channels.collect(), u, y, ts).unwrap().starting_at(start)
            })
        },
    )
}

fn bits(record: &Record) -> Vec<Option<u64>> {
    let values = record.samples().flat_map(|(u, y)| u.iter().chain(y));
    values.map(|v| (!v.is_nan()).then_some(v.to_bits())).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn records_survive_a_file_to_the_bit(record in any_record()) {
        let mut csv = Vec::new();
        write_log_to("run.csv", &mut csv, &record).unwrap();
        let map = LogMap::for_channels(record.inputs(), record.outputs());
        let back = read_log_from("run.csv", &csv[..], &map).unwrap().record;
        prop_assert_eq!(back.inputs(), record.inputs());
        prop_assert_eq!(back.outputs(), record.outputs());
        prop_assert_eq!(back.ts(), record.ts());
        prop_assert_eq!(back.time(0).to_bits(), record.time(0).to_bits());
        prop_assert_eq!(bits(&back), bits(&record));
    }

    #[test]
    fn the_order_and_separator_of_columns_do_not_matter(
        order in Just([0, 1, 2, 3]).prop_shuffle(),
        separator in prop_oneof![Just(","), Just(";"), Just("\t")],
        newline in prop_oneof![Just("\n"), Just("\r\n")],
        mark in prop_oneof![Just(""), Just("\u{feff}")],
    ) {
        let columns = [
            ["time", "0", "0.5", "1"],
            ["wf [g/s]", "100", "", "300"],
            ["\"T_7 [K]\"", "900", "901.5", "NaN"],
            ["remark", "start", "", "'end'"],
        ];
        let row = |i: usize| {
            order.iter().map(|&c| columns[c][i]).collect::<Vec<_>>().join(separator)
        };
        let csv = mark.to_owned() + &(0..4).map(row).collect::<Vec<_>>().join(newline);
        let record = read(&csv).unwrap().record;
        let u: Vec<f64> = record.input(0).collect();
        let y: Vec<f64> = record.output(0).collect();
        // One rounding each in 1/1000 and in its product.
        prop_assert!((u[0] - 0.1).abs() < 1e-16 && (u[2] - 0.3).abs() < 1e-16, "{u:?}");
        prop_assert!(u[1].is_nan() && y[2].is_nan());
        prop_assert_eq!(&y[..2], &[900.0, 901.5]);
        prop_assert_eq!(record.ts().seconds().to_bits(), 0.5_f64.to_bits());
    }
}

#[test]
fn a_bad_cell_is_named_with_its_row() {
    let expected = "column `wf` of run3.csv, row 3: expected a finite number, found `abc`";
    for csv in [
        "t,wf,T_7\n0,1,2\n1,abc,2\n",
        "t,wf,T_7\r\n0,1,2\r\n1,abc,2\r\n",
        "t,wf,T_7\n0,1,2\n1,abc,2",
        "\u{feff}t;wf;T_7\n0;1;2\n1;abc;2\n",
    ] {
        assert_eq!(message(csv), expected, "{csv:?}");
    }
    // Comments before the header and blank lines between rows count.
    for newline in ["\n", "\r\n"] {
        let csv = "# by hand\n\nt,wf,T_7\n0,1,2\n\n1,abc,2\n".replace('\n', newline);
        assert!(message(&csv).contains("row 6:"), "{}", message(&csv));
    }
    assert!(message("t,wf,T_7\n0,inf,2\n").ends_with("found `inf`"));
    assert!(
        message("t,wf,T_7\n,1,2\n").starts_with("column `t` of run3.csv, row 2: expected a time")
    );
}

#[test]
fn missing_columns_list_what_there_is() {
    assert_eq!(
        message("t,Wf,T_7\n0,1,2\n"),
        "run3.csv: there is no column `wf`, did you mean `Wf`?; the columns are [\"t\", \"Wf\", \"T_7\"]"
    );
    assert_eq!(
        message("t,fuel,T_7\n0,1,2\n"),
        "run3.csv: there is no column `wf`; the columns are [\"t\", \"fuel\", \"T_7\"]"
    );
    assert!(matches!(read("stamp,wf,T_7\n0,1,2\n"), Err(LogError::NoTime { .. })));
    assert!(matches!(read("t,wf,T_7,T_7\n0,1,2,3\n"), Err(LogError::AmbiguousColumn { .. })));
    assert!(matches!(
        read_log_from("run3.csv", "t,y\n0,1\n".as_bytes(), &LogMap::default()),
        Err(LogError::NoOutputs { .. })
    ));
}

#[test]
fn empty_files_and_headers_alone_are_errors() {
    for csv in ["", "\n\n", "# comment\n"] {
        assert!(matches!(read(csv), Err(LogError::Empty { .. })), "{csv:?}");
    }
    assert_eq!(message("t,wf,T_7\n"), "run3.csv: expected rows after the header, found none");
    let error = read("t,wf,T_7\n0,1,2\n").unwrap_err();
    let LogError::TimeBase { source, .. } = error else { panic!("{error}") };
    assert_eq!(*source, TimeBaseError::TooShort { samples: 1 });
}

#[test]
fn time_must_go_forward() {
    assert_eq!(
        message("t,wf,T_7\n0,1,2\n1,1,2\n0.5,1,2\n"),
        "column `t` of run3.csv, row 4: expected a time after 1 s, found 0.5 s"
    );
    let mut map = map();
    map.resample.disorder = Disorder::Drop;
    let csv = "t,wf,T_7\n0,1,2\n1,1,3\n0.5,9,9\n1,9,9\n2,1,4\n";
    let log = read_log_from("run3.csv", csv.as_bytes(), &map).unwrap();
    assert_eq!(log.record.output(0).collect::<Vec<_>>(), [2.0, 3.0, 4.0]);
    assert_eq!((log.time_base.duplicates, log.time_base.out_of_order), (1, 1));
}

#[test]
fn units_come_from_the_header_or_the_map_and_must_fit() {
    let record = read("t [min],wf [lb/s],T_7 (degC)\n0,1,0\n1,1,100\n").unwrap().record;
    assert_eq!(record.ts().seconds().to_bits(), 60.0_f64.to_bits());
    assert!((record.u(0)[0] - 0.453_592_37).abs() < 1e-15);
    assert!((record.y(1)[0] - 373.15).abs() < 1e-12);
    assert_eq!(
        message("t,wf,T_7 [kPa]\n0,1,0\n"),
        "column `T_7 [kPa]` of run3.csv: `kPa` (Pressure) cannot be converted to `K` (Temperature)"
    );
    let mut map = map();
    map.outputs[0].column_unit = Some("degC".to_owned());
    let read = |csv: &str| read_log_from("run3.csv", csv.as_bytes(), &map);
    assert!((read("t,wf,T_7\n0,1,0\n1,1,0\n").unwrap().record.y(0)[0] - 273.15).abs() < 1e-12);
    assert_eq!(
        read("t,wf,T_7 [K]\n0,1,0\n").unwrap_err().to_string(),
        "column `T_7 [K]` of run3.csv: the header says [K], the column map says [degC]"
    );
}

#[test]
fn rows_of_the_wrong_length_and_bytes_that_are_no_text() {
    assert_eq!(message("t,wf,T_7\n0,1\n"), "run3.csv, row 2: expected 3 cells, found 2");
    let read = |bytes: &[u8]| read_log_from("run3.csv", bytes, &map()).unwrap_err();
    assert_eq!(
        read(b"t,wf,T_7\n0,1,\x81\n").to_string(),
        "run3.csv, row 2: expected text in UTF-8 or Windows-1252, found `\\x81`"
    );
    assert!(matches!(read(b"t,wf,T_7 [\x01C]\xb0\n"), LogError::NotText { row: 1, .. }));
}

#[test]
fn decimal_commas_and_given_separators() {
    let mut map = map();
    map.decimal_comma = true;
    let csv = "t;wf;T_7\n0;1,5;2\n0,5;1,5;2\n";
    let record = read_log_from("run3.csv", csv.as_bytes(), &map).unwrap().record;
    assert_eq!((record.u(0), record.ts().seconds()), (&[1.5][..], 0.5));
    map.decimal_comma = false;
    map.delimiter = Some('|');
    let csv = "t|wf|T_7\n0|1.5|2\n1|1.5|2\n";
    assert_eq!(read_log_from("run3.csv", csv.as_bytes(), &map).unwrap().record.u(1), [1.5]);
    map.delimiter = Some('→');
    assert!(matches!(
        read_log_from("run3.csv", csv.as_bytes(), &map),
        Err(LogError::Delimiter { found: '→', .. })
    ));
}

#[test]
fn rows_can_be_samples() {
    let mut map = map();
    map.time = TimeMap::every(SampleTime::new(0.25).unwrap());
    let log = read_log_from("run3.csv", "wf,T_7\n1,2\n3,4\n".as_bytes(), &map).unwrap();
    assert_eq!((log.record.ts().seconds(), log.record.len()), (0.25, 2));
    assert!(log.time_base.even);
}

#[test]
fn columns_can_have_other_names_than_channels() {
    let map = LogMap {
        time: TimeMap::in_column("stamp"),
        outputs: vec![ColumnMap::new("power", "P_el [W]").in_unit("kW")],
        ..LogMap::default()
    };
    let csv = "stamp,P_el [W],P_el [V]\n0,1500,1\n1,2500,1\n";
    let record = read_log_from("run3.csv", csv.as_bytes(), &map).unwrap().record;
    assert_eq!(record.outputs(), [Channel::new("power", "kW")]);
    assert_eq!(record.output(0).collect::<Vec<_>>(), [1.5, 2.5]);
}

#[test]
fn unknown_versions_are_refused() {
    assert_eq!(
        message("# fdiag-log version=2\nt,wf,T_7\n"),
        "run3.csv, row 1: expected log format version 1, found 2"
    );
    assert_eq!(
        message("# fdiag-log version=1 sample_time=1s\nt,wf,T_7\n"),
        "column `sample_time` of run3.csv, row 1: expected a finite number, found `1s`"
    );
}

#[test]
fn files_are_written_whole_and_huge_logs_are_streamed() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.csv");
    let n = 100_000;
    let y: Vec<f64> = (0..n).map(|k| f64::from(k).sin()).collect();
    let ts = SampleTime::new(0.1).unwrap();
    let record = Record::new(vec![], Channel::numbered("y", 1), vec![], y, ts).unwrap();
    write_log(&path, &record).unwrap();
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);

    let map = LogMap::for_channels(&[], record.outputs());
    assert_eq!(read_log(&path, &map).unwrap().record, record);
    let mut reader = LogReader::new(open(&path, &map).unwrap(), &map).unwrap();
    let mut count = 0;
    while let Some(row) = reader.next_row().unwrap() {
        assert_eq!(row.y[0].to_bits(), record.y(count)[0].to_bits());
        // After the comment and the header.
        assert_eq!(row.row, count as u64 + 3);
        count += 1;
    }
    assert_eq!(count, record.len());

    let nowhere = directory.path().join("missing").join("run.csv");
    let error = write_log(&nowhere, &record).unwrap_err();
    assert!(
        matches!(
            error,
            LogError::Io { action: FileAction::Write, kind: io::ErrorKind::NotFound, .. }
        ),
        "{error}"
    );
    let error = read_log(&nowhere, &map).unwrap_err().to_string();
    assert!(error.ends_with("run.csv: cannot read: there is no such file or folder"), "{error}");
}

#[test]
fn records_that_would_not_come_back_are_not_written() {
    let write = |u: &str, y: &str| {
        let ts = SampleTime::new(1.0).unwrap();
        let (inputs, outputs) = (vec![Channel::new(u, "1")], vec![Channel::new(y, "1")]);
        let record = Record::new(inputs, outputs, vec![0.0], vec![0.0], ts).unwrap();
        write_log_to("run.csv", &mut io::sink(), &record)
    };
    assert!(matches!(write("y", "y"), Err(LogError::DuplicateColumn { .. })));
    assert!(matches!(write("u", "time"), Err(LogError::DuplicateColumn { .. })));
    assert!(matches!(write(" u", "y"), Err(LogError::Unwritable { .. })));
    assert!(matches!(write("", "y"), Err(LogError::Unwritable { .. })));
}

#[test]
fn dates_are_times() {
    let csv = "time,wf,T_7\n2026-11-23T23:59:59.5Z,1,2\n2026-11-24 00:00:00,1,3\n2026-11-24T01:00:00.500+01:00,1,4\n";
    let record = read(csv).unwrap().record;
    assert_eq!((record.ts().seconds(), record.time(0), record.len()), (0.5, 86_399.5, 3));
    // In a column of numbers a date is none.
    assert!(message("t,wf,T_7\n0,1,5\n1,1,2026-11-23\n").ends_with("found `2026-11-23`"));
}

#[test]
fn channels_can_be_constant_and_files_can_have_rows_of_their_own() {
    let map: LogMap = toml::from_str(
        "inputs = [{ name = 'g', unit = 'm/s^2', constant = 1.0, column_unit = 'g0' }]\n\
         outputs = [{ name = 'y' }]\n\
         logs = [{ file = 'run3.csv', rows = [{ column = 't', from = 1 }] }]",
    )
    .unwrap();
    let csv = "t,y\n0,5\n1,6\n2,7\n";
    let record = read_log_from("data/run3.csv", csv.as_bytes(), &map).unwrap().record;
    assert_eq!((record.len(), record.u(0), record.y(0)), (2, &[9.80665][..], &[6.0][..]));
    assert_eq!(read_log_from("run4.csv", csv.as_bytes(), &map).unwrap().record.len(), 3);
    let both: LogMap =
        toml::from_str("outputs = [{ name = 'y', column = 'y', constant = 2.0 }]").unwrap();
    let error = read_log_from("run3.csv", csv.as_bytes(), &both).unwrap_err().to_string();
    assert!(error.ends_with("found 2 and column `y`"), "{error}");
}
