//! MAT-files of version 5, as scipy writes them, and as nobody should.

#![cfg(feature = "mat")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]
#![allow(clippy::float_cmp, reason = "what is compared so was written exactly")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "letters are written as bytes"
)]

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

/// A matrix of version 4, column by column.
fn v4(kind: u32, name: &str, [rows, columns]: [usize; 2], values: &[f64]) -> Vec<u8> {
    let word = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
    let head = [kind.to_le_bytes(), word(rows), word(columns), word(0), word(name.len() + 1)];
    let letters = |value: &f64| vec![*value as u8];
    let data = values.iter().flat_map(|value| match kind {
        51 => letters(value),
        _ => value.to_le_bytes().to_vec(),
    });
    let name = [name.as_bytes(), b"\0"].concat();
    head.concat().into_iter().chain(name).chain(data).collect()
}

/// Lines of text as a matrix of letters: each a row, or each a column.
fn v4_text(name: &str, lines: &[&str], is_transposed: bool) -> Vec<u8> {
    let length = lines.iter().map(|line| line.len()).max().unwrap_or(0);
    let letter = |line: usize, k: usize| f64::from(*lines[line].as_bytes().get(k).unwrap_or(&b' '));
    let (rows, columns) = if is_transposed { (length, lines.len()) } else { (lines.len(), length) };
    let at = |cell: usize| {
        let (row, column) = (cell % rows, cell / rows);
        if is_transposed { letter(column, row) } else { letter(row, column) }
    };
    v4(51, name, [rows, columns], &(0..rows * columns).map(at).collect::<Vec<_>>())
}

fn read_as(bytes: &[u8], outputs: &str) -> Result<fd_log::Log, LogError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mat");
    std::fs::write(&path, bytes).unwrap();
    read_log(&path, &toml::from_str(&format!("outputs = [{outputs}]")).unwrap())
}

#[test]
fn version_4_is_read() {
    let ramp: Vec<f64> = (0..40).map(|k| f64::from(k) / 4.0).collect();
    let q: Vec<f64> = ramp.iter().copied().chain(ramp.iter().map(|x| -x)).collect();
    let file = [
        v4(0, "t", [1, 40], &ramp),
        v4(0, "q", [40, 2], &q),
        v4_text("note", &["hello"], false),
        v4(0, "gain", [1, 1], &[2.0]),
    ]
    .concat();
    let log = read_as(&file, "{ name = 'q[1]' }").unwrap().record;
    assert_eq!((log.len(), log.y(39), log.ts().seconds()), (40, &[-9.75][..], 0.25));
    let error = read_as(&file, "{ name = 'note' }").unwrap_err().to_string();
    assert!(error.ends_with("found text"), "{error}");
    for length in 20..file.len() {
        drop(read_as(&file[..length], "{ name = 'q[1]' }"));
    }
    let other = read_as(&[b'x'; 200], "{ name = 'q' }").unwrap_err().to_string();
    assert!(other.contains("found neither version 5 or 7.3, nor a matrix of version 4"), "{other}");
}

#[test]
fn results_of_modelica_tools_are_read_by_the_names_of_their_variables() {
    let time = [0.0, 0.5, 1.0, 1.0, 1.5, 2.0];
    let x = [1.0, 2.0, 3.0, 7.0, 8.0, 9.0];
    for is_transposed in [true, false] {
        let form = if is_transposed { "binTrans" } else { "binNormal" };
        // Variables by rows or by columns.
        let table = |series: &[&[f64]]| {
            let (count, length) = (series.len(), series[0].len());
            let cells = (0..count * length).map(|cell| {
                if is_transposed {
                    series[cell % count][cell / count]
                } else {
                    series[cell / length][cell % length]
                }
            });
            let shape = if is_transposed { [count, length] } else { [length, count] };
            (shape, cells.collect::<Vec<_>>())
        };
        let places: [[f64; 4]; 4] = [
            [0.0, 1.0, 0.0, -1.0],
            [2.0, 2.0, 0.0, -1.0],
            [2.0, -2.0, 0.0, -1.0],
            [1.0, 2.0, 0.0, 0.0],
        ];
        // `dataInfo` stands the other way round.
        let (shape, cells) = if is_transposed {
            ([4, 4], places.concat())
        } else {
            ([4, 4], (0..16).map(|cell| places[cell % 4][cell / 4]).collect())
        };
        let info = v4(0, "dataInfo", shape, &cells);
        let (shape, cells) = table(&[&[0.0, 2.0], &[4.0, 4.0]]);
        let first = v4(0, "data_1", shape, &cells);
        let (shape, cells) = table(&[&time, &x]);
        let second = v4(0, "data_2", shape, &cells);
        let names = ["time", "motor.phi", "motor.minus", "J"];
        let said = ["Time [s]", "Angle [deg|rad]", "", "Inertia [kg.m2]"];
        let file = [
            v4_text("Aclass", &["Atrajectory", "1.1", "", form], false),
            v4_text("name", &names, is_transposed),
            v4_text("description", &said, is_transposed),
            info,
            first,
            second,
        ]
        .concat();
        let log = read_as(&file, "{ name = 'motor.phi', unit = 'rad' }, { name = 'motor.minus' }");
        let log = log.unwrap_or_else(|error| panic!("{form}: {error}")).record;
        // Of the two rows of an event the later one.
        assert_eq!((log.len(), log.ts().seconds()), (5, 0.5));
        assert!((log.y(2)[0] - 7_f64.to_radians()).abs() < 1e-15 && log.y(2)[1] == -7.0, "{form}");
        let error = read_as(&file, "{ name = 'J' }").unwrap_err().to_string();
        assert!(error.ends_with("found a value that never changes: 4"), "{error}");
    }
}
