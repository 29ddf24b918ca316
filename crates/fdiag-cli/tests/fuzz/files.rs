//! Files that programs write: logs of every format, and what simulators send.

use std::{fs, time::Duration};

use fdiag::{
    log::{LogMap, info, read_log},
    sim::{
        model::Model,
        outside::{OutsideSimulator, Process, serve, stated},
        simulate::{EquationSimulator, Simulator},
    },
};

use super::engine::{fuzz, seeds};

/// Reads a log as a stranger would, and with a map.
fn log(name: &str, file: &str, files: &[&str], map: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(file);
    let map: LogMap = toml::from_str(map).unwrap();
    fuzz(name, seeds(name, files), &|input| {
        fs::write(&path, input).unwrap();
        let told =
            info(&path, &map).map_or_else(|e| e.to_string(), |info| format!("{:?}", info.format));
        let read = read_log(&path, &map);
        let read = read.map_or_else(|e| e.to_string(), |log| format!("{:?}", log.record.len()));
        format!("{told} {read}")
    });
}

#[test]
fn csv() {
    let map =
        "inputs = [{ name = 'wf', column = 'fuel' }]\noutputs = [{ name = 'T', column = 'T_7' }]";
    log("csv", "run.csv", &["examples/turbine-run.csv"], map);
}

#[test]
fn ndjson_and_zstandard() {
    let map = "outputs = [{ name = 'y', column = 'y' }]";
    log("zst", "run.ndjson.zst", &["crates/fd-log/tests/data/run.ndjson.zst"], map);
}

#[test]
fn csv_and_gzip() {
    let map = "outputs = [{ name = 'y', column = 'y' }]";
    log("gz", "run.csv.gz", &["crates/fd-log/tests/data/run.csv.gz"], map);
}

#[test]
fn npz() {
    let map = "outputs = [{ name = 'y', column = 'y' }]";
    let files = ["crates/fd-log/tests/data/arrays.npz", "crates/fd-log/tests/data/packed.npz"];
    log("npz", "run.npz", &files, map);
}

#[test]
fn npy() {
    let map = "outputs = [{ name = 'y', column = '1' }]";
    log("npy", "run.npy", &["crates/fd-log/tests/data/matrix.npy"], map);
}

#[test]
fn mcap() {
    let map = "outputs = [{ name = 'y', column = '/joint_states.position[elbow]' }]";
    let files = ["crates/fd-log/tests/data/robot.mcap", "crates/fd-log/tests/data/robot.lz4.mcap"];
    log("mcap", "run.mcap", &files, map);
}

#[test]
fn ulog() {
    let map = "outputs = [{ name = 'y', column = 'y' }]";
    log("ulog", "run.ulg", &["crates/fd-log/tests/data/flight.ulg"], map);
}

#[cfg(feature = "parquet")]
#[test]
fn parquet() {
    let map = "outputs = [{ name = 'y', column = 'y' }]";
    let files =
        ["crates/fd-log/tests/data/table.parquet", "crates/fd-log/tests/data/table.zstd.parquet"];
    log("parquet", "run.parquet", &files, map);
}

fn sum() -> EquationSimulator {
    let model: Model = "version = 1\nkind = \"equations\"\nname = \"sum\"\nsample_time = 1.0\n\
        inputs = { u = { unit = \"1\" } }\nstates = { x = { unit = \"1\", initial = 0.0, update = \"x + u\" } }\n\
        outputs = { y = { unit = \"1\", value = \"x\" } }\n"
        .parse()
        .unwrap();
    EquationSimulator::new(&model).unwrap()
}

/// Frames of the protocol: op, lanes, count, values.
fn frames(frames: &[(u32, &[f64])]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (op, values) in frames {
        for word in [*op, 1, u32::try_from(values.len()).unwrap()] {
            bytes.extend(word.to_le_bytes());
        }
        values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    }
    bytes
}

#[test]
fn questions_of_the_process_protocol() {
    let asked = [
        frames(&[(1, &[0.0, 7.0]), (2, &[1.0]), (2, &[0.5]), (5, &[])]),
        frames(&[(3, &[0.0, 2.0, 7.0, 1.0, 1.0]), (5, &[])]),
    ];
    let own = asked.map(|frames| [b"{}\n".to_vec(), frames].concat()).to_vec();
    fuzz("serve", [seeds("serve", &[]), own].concat(), &|input| {
        let mut simulator = sum();
        let hello = stated("sum", &simulator, &[]);
        let mut answer = Vec::new();
        let served = serve(&mut simulator, &hello, input, &mut answer);
        served.map_or_else(|error| error.to_string(), |()| answer.len().to_string())
    });
}

/// A simulator that answers at once and with anything: a file that is shown.
#[test]
#[cfg(unix)]
fn answers_of_the_process_protocol() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("answers");
    let hello = stated("sum", &sum(), &[]);
    let mut asked = b"{}\n".to_vec();
    asked.extend(frames(&[
        (1, &[0.0, 0.0]),
        (2, &[1.0]),
        (3, &[0.0, 2.0, 0.0, 0.1, 0.1]),
        (5, &[]),
    ]));
    let mut answers = Vec::new();
    serve(&mut sum(), &hello, &asked[..], &mut answers).unwrap();
    fuzz("answers", [seeds("answers", &[]), vec![answers]].concat(), &|input| {
        fs::write(&path, input).unwrap();
        let mut process = Process::new(["cat", path.to_str().unwrap()]);
        process.timeout = Duration::from_secs(2);
        let made = process.contract().and_then(|c| OutsideSimulator::new(c, process.clone(), 1));
        match made {
            Ok(mut simulator) => {
                let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
                let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
                let (nu, ny) = (simulator.inputs().len(), simulator.outputs().len());
                let mut y = vec![0.0; 2 * ny];
                let outcome = simulator.simulate(&theta, &x0, &vec![0.1; 2 * nu], &mut y);
                let trouble = simulator.trouble().map(|error| error.to_string());
                format!("{outcome:?} {trouble:?}")
            }
            Err(error) => error.to_string(),
        }
    });
}
