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

use super::{Target, seeds};

/// Reads a log as a stranger would, and with a map.
fn log(name: &'static str, file: &str, files: &[&str], map: &str) -> Target {
    let folder = tempfile::tempdir().unwrap();
    let file = file.to_owned();
    let map: LogMap = toml::from_str(map).unwrap();
    Target::new(name, seeds(files), move |input| {
        let path = folder.path().join(&file);
        fs::write(&path, input).unwrap();
        let told =
            info(&path, &map).map_or_else(|e| e.to_string(), |info| format!("{:?}", info.format));
        let read = read_log(&path, &map);
        let read = read.map_or_else(|e| e.to_string(), |log| format!("{:?}", log.record.len()));
        format!("{told} {read}")
    })
}

/// A log of which one output is read, from files among the data of the reader's own tests.
fn own_log(name: &'static str, file: &str, column: &str, files: &[&str]) -> Target {
    let map = format!("outputs = [{{ name = 'y', column = '{column}' }}]");
    let files: Vec<String> =
        files.iter().map(|file| format!("crates/fd-log/tests/data/{file}")).collect();
    log(name, file, &files.iter().map(String::as_str).collect::<Vec<_>>(), &map)
}

pub fn csv() -> Target {
    let map =
        "inputs = [{ name = 'wf', column = 'fuel' }]\noutputs = [{ name = 'T', column = 'T_7' }]";
    log("csv", "run.csv", &["examples/turbine-run.csv"], map)
}

pub fn ndjson() -> Target {
    let own = b"{\"time\":0,\"y\":1.5,\"s\":{\"x\":[1,2.5,null]}}\n{\"time\":0.1,\"y\":-2e-3,\"on\":true}\n";
    let mut target = own_log("ndjson", "run.ndjson", "y", &[]);
    target.seeds.push(own.to_vec());
    target
}

pub fn csv_and_gzip() -> Target {
    own_log("gz", "run.csv.gz", "y", &["run.csv.gz"])
}

pub fn ndjson_and_zstandard() -> Target {
    own_log("zst", "run.ndjson.zst", "y", &["run.ndjson.zst"])
}

pub fn npz() -> Target {
    own_log("npz", "run.npz", "y", &["arrays.npz", "packed.npz"])
}

pub fn npy() -> Target {
    own_log("npy", "run.npy", "1", &["matrix.npy"])
}

pub fn mcap() -> Target {
    let column = "/joint_states.position[elbow]";
    own_log("mcap", "run.mcap", column, &["robot.mcap", "robot.lz4.mcap"])
}

pub fn rosbag() -> Target {
    own_log("rosbag", "run.db3", "/cmd_vel.linear.x", &["humble.db3", "robot.db3"])
}

pub fn ulog() -> Target {
    own_log("ulog", "run.ulg", "y", &["flight.ulg"])
}

pub fn hdf5() -> Target {
    own_log("hdf5", "run.h5", "y", &["latest.h5", "run.h5", "matlab73.mat"])
}

pub fn mat() -> Target {
    own_log("mat", "run.mat", "log.deep.q[0]", &["plain.mat", "packed.mat"])
}

/// Without its feature, that it is refused.
pub fn parquet() -> Target {
    own_log("parquet", "run.parquet", "y", &["table.parquet", "table.zstd.parquet"])
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

pub fn questions_of_the_process_protocol() -> Target {
    let asked = [
        frames(&[(1, &[0.0, 7.0]), (2, &[1.0]), (2, &[0.5]), (5, &[])]),
        frames(&[(3, &[0.0, 2.0, 7.0, 1.0, 1.0]), (5, &[])]),
    ];
    let own = asked.map(|frames| [b"{}\n".to_vec(), frames].concat()).to_vec();
    Target::new("serve", own, move |input| {
        let mut simulator = sum();
        let hello = stated("sum", &simulator, &[]);
        let mut answer = Vec::new();
        let served = serve(&mut simulator, &hello, input, &mut answer);
        served.map_or_else(|error| error.to_string(), |()| answer.len().to_string())
    })
}

/// A simulator that answers at once and with anything: a file that is shown.
pub fn answers_of_the_process_protocol() -> Target {
    let folder = tempfile::tempdir().unwrap();
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
    Target::new("answers", vec![answers], move |input| {
        let path = folder.path().join("answers");
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
    })
}
