//! Other people's files, `../shared/data/people`: what each `expected.md` says is right.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]
#![allow(clippy::float_cmp, reason = "what is compared so was written exactly")]

use std::path::PathBuf;

use fd_log::{LogError, LogMap, info, read_log};
use fd_model::Channel;

fn people(name: &str) -> PathBuf {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/people");
    let file = PathBuf::from(folder).join(name);
    assert!(file.is_file(), "the logs are missing: no file {}", file.display());
    file
}

fn map(text: &str) -> LogMap {
    toml::from_str(text).unwrap()
}

#[test]
#[ignore = "needs the logs of ../shared/data"]
fn loggers_are_read_or_doubted() {
    for (file, power, temperature) in [
        ("de1", "Leistung", "Temperatur"),
        ("de1_16", "Leistung", "Temperatur"),
        ("de2", "Leistung", "Temperatur"),
        ("de4", "Leistung", "Temperatur"),
        ("de5", "Leistung", "Temperatur"),
        ("us1", "P", "T"),
        ("hms", "P", "T"),
        ("logger", "P", "T"),
        ("units2", "P", "T"),
    ] {
        let path = people(&format!("p11-loggers/{file}.csv"));
        let map =
            LogMap::for_channels(&[Channel::new(power, "W")], &[Channel::new(temperature, "K")]);
        let log = read_log(path, &map).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((log.record.len(), log.record.ts().seconds()), (12, 30.0), "{file}");
        let first = if file == "de5" { 1000.5 } else { 100.0 };
        assert_eq!(log.record.u(0), [first], "{file}");
        assert!((log.record.y(3)[0] - 293.45).abs() < 1e-9, "{file}");
    }
    for (file, doubt) in [("xls", "days of a spreadsheet?"), ("ns", "are ns since 1970")] {
        let found = info(people(&format!("p11-loggers/{file}.csv")), &LogMap::default()).unwrap();
        let doubts = &found.tables[0].clock.as_ref().unwrap().doubts;
        assert!(doubts[0].contains(doubt), "{file}: {doubts:?}");
    }
}

#[test]
#[ignore = "needs the logs of ../shared/data"]
fn a_capital_t_is_no_time_and_rows_without_one_can_be_cut() {
    let found = info(people("p05-T-as-time/log.csv"), &LogMap::default()).unwrap();
    let clock = found.tables[0].clock.as_ref().unwrap();
    assert_eq!((clock.column.as_str(), clock.median_step_s), ("timestamp", 30.0));
    let cut: LogMap =
        toml::from_str(&std::fs::read_to_string(people("p14-rows-without-time/map.toml")).unwrap())
            .unwrap();
    let log = read_log(people("p14-rows-without-time/log.csv"), &cut).unwrap();
    assert_eq!((log.record.len(), log.record.ts().seconds()), (200, 6.0));
}

#[test]
#[ignore = "needs the logs of ../shared/data"]
fn other_formats_are_read_or_named() {
    let said = |file: &str| {
        let error = read_log(people(file), &map("outputs = [{ name = 'y' }]")).unwrap_err();
        (matches!(error, LogError::NoLog { expected: "a log", .. }), error.to_string())
    };
    let (is_foreign, bag) = said("p15-other-formats/ros1.bag");
    assert!(is_foreign && bag.contains("ROS 1"), "{bag}");
    let (_, own) = said("p06-db3-own-message/drive_0.db3");
    assert!(own.contains("ros2 bag convert") && !own.contains("[("), "{own}");
    for file in ["json.mcap", "v4.mat", "v5.mat"] {
        let found = info(people(&format!("p15-other-formats/{file}")), &LogMap::default()).unwrap();
        let columns = found.tables.iter().map(|table| table.columns.len()).sum::<usize>();
        assert!(columns > 0 && found.tables[0].rows > 1, "{file}: {found:?}");
    }
}

#[test]
#[ignore = "needs the logs of ../shared/data"]
fn what_is_no_column_of_matlab_is_left_out_by_name() {
    let found = info(people("p07-mat73/log.mat"), &LogMap::default()).unwrap();
    let columns = found.tables.iter().flat_map(|table| &table.columns);
    let mut names: Vec<&str> = columns.map(|column| column.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["t", "u", "y"], "{:?}", found.left);
    for (name, why) in [
        ("operator", "text"),
        ("tt", "an object"),
        ("sp", "a sparse matrix"),
        ("z", "complex numbers"),
        ("nothing", "empty"),
    ] {
        let left = found.left.iter().find(|(left, _)| left == name);
        assert!(left.is_some_and(|(_, said)| said.starts_with(why)), "{name}: {:?}", found.left);
    }
}
