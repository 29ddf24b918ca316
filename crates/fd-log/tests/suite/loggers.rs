//! Logs as European and US loggers and spreadsheets write them; `../shared/data/people/p11-loggers` has files of these
//! kinds.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]
#![allow(clippy::needless_pass_by_value, reason = "what a test makes, it may hand over")]
#![allow(clippy::float_cmp, reason = "what is compared so was written exactly")]

use fd_log::{DateOrder, LogError, LogInfo, LogMap, info, read_log_from};
use fd_model::Channel;

/// Power and temperature of a log.
fn map(power: &str, temperature: &str) -> LogMap {
    LogMap::for_channels(&[Channel::new(power, "W")], &[Channel::new(temperature, "K")])
}

/// Twelve rows over midnight, 30 s apart, with the time written by `time`.
fn rows(time: impl Fn(usize) -> String, row: impl Fn(usize, String) -> String) -> String {
    (0..12).map(|k| row(k, time(k))).collect()
}

/// Time of day, from 23:59:00 on.
fn of_day(k: usize) -> (usize, String) {
    let seconds = 86_340 + 30 * k;
    let (day, rest) = (seconds / 86_400, seconds % 86_400);
    (day, format!("{:02}:{:02}:{:02}", rest / 3600, rest / 60 % 60, rest % 60))
}

fn comma(number: f64) -> String {
    format!("{number:.2}").replace('.', ",")
}

fn is_read(bytes: &[u8], map: &LogMap) {
    let log = read_log_from("run.csv", bytes, map).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((log.record.len(), log.record.ts().seconds()), (12, 30.0));
    for k in 0..12 {
        assert_eq!(log.record.u(k), [100.0 + k as f64], "{k}");
        // The offset of a temperature rounds once.
        assert!((log.record.y(k)[0] - (293.15 + k as f64 / 10.0)).abs() < 1e-12, "{k}");
    }
}

fn german(k: usize, time: String) -> String {
    format!("{time};{};{}\n", comma(100.0 + k as f64), comma(20.0 + k as f64 / 10.0))
}

fn american(k: usize, time: String) -> String {
    format!("{time},{},{:.2}\n", 100 + k, 20.0 + k as f64 / 10.0)
}

const GERMAN: &str = "Leistung [W];Temperatur [°C]\n";
const AMERICAN: &str = "P [W],T [degC]\n";

fn info_of(text: &str) -> LogInfo {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    std::fs::write(&path, text).unwrap();
    info(&path, &LogMap::default()).unwrap()
}

#[test]
fn german_loggers_are_read_as_they_are() {
    let stamp = |k| {
        let (day, time) = of_day(k);
        format!("{:02}.02.2024 {time}", 1 + day)
    };
    let text = format!("Zeitstempel;{GERMAN}{}", rows(stamp, german));
    let map = map("Leistung", "Temperatur");
    is_read(text.as_bytes(), &map);
    // Windows-1252, and UTF-16 in both orders.
    let windows: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    is_read(&windows, &map);
    for to_bytes in [u16::to_le_bytes, u16::to_be_bytes] {
        let wide: Vec<u8> = format!("\u{feff}{text}").encode_utf16().flat_map(to_bytes).collect();
        is_read(&wide, &map);
    }
    let parted = |k| {
        let (day, time) = of_day(k);
        format!("{:02}.02.2024;{time}", 1 + day)
    };
    is_read(format!("Datum;Uhrzeit;{GERMAN}{}", rows(parted, german)).as_bytes(), &map);
    let found = info_of(&text);
    assert_eq!(found.notes, ["numbers have a decimal comma"]);
    assert_eq!(found.tables[0].clock.as_ref().unwrap().doubts, Vec::<String>::new());
}

#[test]
fn thousands_may_be_set_apart() {
    let stamp = |k| {
        let (day, time) = of_day(k);
        format!("2024-02-{:02} {time}", 1 + day)
    };
    let row = |k: usize, time: String| format!("{time};1.{:03},5;{}\n", 9 * k, comma(20.0));
    let text = format!("time;{GERMAN}{}", rows(stamp, row));
    let record =
        read_log_from("r", text.as_bytes(), &map("Leistung", "Temperatur")).unwrap().record;
    assert_eq!((record.u(0), record.u(11)), (&[1000.5][..], &[1099.5][..]));
}

#[test]
fn american_loggers_are_read_where_the_order_of_the_date_shows() {
    let stamp = |k| {
        let (day, time) = of_day(k);
        let hour: usize = time[..2].parse().unwrap();
        let (half, hour) = if hour < 12 { ("AM", (hour + 11) % 12 + 1) } else { ("PM", hour - 12) };
        format!("02/{:02}/2024 {hour:02}{} {half}", 1 + day, &time[2..])
    };
    is_read(format!("time,{AMERICAN}{}", rows(stamp, american)).as_bytes(), &map("P", "T"));
    is_read(
        format!("time,{AMERICAN}{}", rows(|k| of_day(k).1, american)).as_bytes(),
        &map("P", "T"),
    );

    // Every fourth of a month, or every day of April: nobody can know.
    let text = "time,P,T\n01/04/2024,1,2\n02/04/2024,1,2\n03/04/2024,1,2\n";
    let mut map = map("P", "T");
    let error = read_log_from("run.csv", text.as_bytes(), &map).unwrap_err();
    assert!(matches!(error, LogError::UnclearDate { row: 3, .. }), "{error}");
    assert!(error.to_string().contains("date_order = \"day-first\""), "{error}");
    map.time.date_order = Some(DateOrder::DayFirst);
    let log = read_log_from("run.csv", text.as_bytes(), &map).unwrap();
    assert_eq!(log.record.ts().seconds(), 86_400.0);
}

#[test]
fn lines_before_the_header_and_units_behind_it_are_seen() {
    let row = |k: usize| format!("{};{};{:.1}\n", 30 * k, 100 + k, 20.0 + k as f64 / 10.0);
    let body: String = (0..12).map(row).collect();
    let logger = "Logger: ABC-12\nSerial: 1234\nStart;01.02.2024\n\n";
    let text = format!("{logger}time;P [W];T [degC]\n{body}");
    is_read(text.as_bytes(), &map("P", "T"));
    assert_eq!(info_of(&text).notes, ["4 lines before the header are skipped"]);
    // Rows are those of the file.
    let wrong = format!("{text}360;x;1\n");
    let error = read_log_from("run.csv", wrong.as_bytes(), &map("P", "T")).unwrap_err();
    assert!(matches!(error, LogError::Number { row: 18, .. }), "{error}");

    for units in ["s;W;degC", "[s];[W];[degC]", ";W;°C"] {
        is_read(format!("time;P;T\n{units}\n{body}").as_bytes(), &map("P", "T"));
    }
    // A header whose rows have another number of cells is an error as before.
    let ragged = read_log_from("run.csv", "t,P,T\n0,1,2,\n1,1,2,\n".as_bytes(), &map("P", "T"));
    assert!(matches!(ragged, Err(LogError::Cells { row: 2, expected: 3, found: 4, .. })));
}

#[test]
fn doubts_about_time_are_the_right_ones() {
    let clock = |text: &str| info_of(text).tables[0].clock.clone().unwrap();
    let days =
        clock("time,y\n45323.99930556,1\n45323.99965278,2\n45324.00000000,3\n45324.00034722,4\n");
    assert!(days.doubts[0].starts_with("days of a spreadsheet?"), "{:?}", days.doubts);
    let month = |k: usize| format!("{}-{:02}-15 00:00:00,{k}\n", 2020 + k / 12, 1 + k % 12);
    let years: String = (0..730).map(month).collect();
    let years = clock(&format!("time,y\n{years}"));
    assert!(years.last_s > 3e7 && years.doubts.is_empty(), "{:?}", years.doubts);
    let ns = clock("timestamp,y\n1706831940000000005,1\n1706831970000000005,2\n");
    assert_eq!((ns.column.as_str(), ns.doubts.len()), ("timestamp", 1));
}

#[test]
fn a_capital_t_is_a_temperature() {
    let log = "timestamp,P,T,Troom\n0,1,20,20\n30,1,21,20\n60,1,22,20\n";
    let map: LogMap = toml::from_str("outputs = [{ name = 'Troom' }]").unwrap();
    let read = read_log_from("log.csv", log.as_bytes(), &map).unwrap();
    assert_eq!(
        (read.record.ts().seconds(), read.time_column.as_deref()),
        (30.0, Some("timestamp"))
    );
    let log = log.replace("timestamp", "when");
    let error = read_log_from("log.csv", log.as_bytes(), &map).unwrap_err();
    assert!(error.to_string().contains("perhaps `time = { column = \"T\" }`"), "{error}");
    // Its unit says that it is time.
    let log = "T [ms],Troom\n0,1\n10,2\n20,3\n";
    assert_eq!(read_log_from("log.csv", log.as_bytes(), &map).unwrap().record.ts().seconds(), 0.01);
}

#[test]
fn rows_without_a_time_can_be_cut_by_it() {
    let log = "duty,y\n1,0\n1,1\n1,2\n1,3\n1,4\n1,5\n";
    let map = |rule: &str| -> LogMap {
        toml::from_str(&format!(
            "outputs = [{{ name = 'y' }}]\ntime = {{ sample_time = 6.0 }}\n[[rows]]\n{rule}"
        ))
        .unwrap()
    };
    let read = |rule: &str| read_log_from("log.csv", log.as_bytes(), &map(rule)).unwrap().record;
    let early = read("expression = 'if(t < 18, 1, 0)'\nequals = 1");
    assert_eq!((early.len(), early.y(2), early.ts().seconds()), (3, &[2.0][..], 6.0));
    let late = read("expression = 't'\nfrom = 12");
    assert_eq!((late.len(), late.y(0), late.time(0)), (4, &[2.0][..], 12.0));
    let none =
        read_log_from("log.csv", log.as_bytes(), &map("expression = 't'\nfrom = 60")).unwrap_err();
    assert!(none.to_string().ends_with("expected rows that fit `60 <= t`, found none"), "{none}");
}
