//! The examples in `docs/formats.md` and in `examples/` are what the documentation says.

use fd_model::{
    Inputs, Simulation,
    file::{LinearModel, LinearSystem},
    signal::SignalSpec,
    unit::KNOWN_UNITS,
};

use crate::{LogMap, RowRule, read_log, read_log_from, write_log_to};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

fn documentation() -> String {
    std::fs::read_to_string(format!("{ROOT}/docs/formats.md")).unwrap()
}

/// The fenced block whose opening line is ` ```language name `.
fn block(name: &str) -> String {
    let text = documentation();
    let mut blocks = text.split("\n```").skip(1).step_by(2);
    let block = blocks.find(|block| block.lines().next().is_some_and(|line| line.ends_with(name)));
    let block = block.unwrap_or_else(|| panic!("no block {name}"));
    block.split_once('\n').unwrap().1.to_owned()
}

#[test]
fn the_documented_files_work_together() {
    let model = LinearModel::parse("model.toml", &block("model.toml")).unwrap();
    let map: LogMap = toml::from_str(&block("map.toml")).unwrap();
    let log = read_log_from("run.csv", block("run.csv").as_bytes(), &map).unwrap();
    assert_eq!(log.record.inputs(), model.input_channels());
    assert_eq!(log.record.outputs(), model.output_channels());
    assert_eq!(log.time_base.samples, 6);
    assert_eq!(log.record.missing().outputs, [1, 0]);
    assert!(log.record.scaled(&model.scaling()).is_ok());
}

#[test]
fn the_documented_expressions_are_computed() {
    let map: LogMap = toml::from_str(&block("computed.toml")).unwrap();
    let csv = "t,/motor.current[0],/motor.angle,/joint.position\n0,1500,180,0\n1,500,360,0.125\n";
    let log = read_log_from("run.csv", csv.as_bytes(), &map).unwrap().record;
    assert_eq!((log.u(0), log.u(1)), (&[0.12][..], &[0.0][..]));
    // Numbers of order ten, to a few roundings.
    assert!((log.y(0)[0] - std::f64::consts::PI).abs() < 1e-14);
    assert!((log.y(1)[0] - (std::f64::consts::TAU - 6.25)).abs() < 1e-14);
}

#[test]
fn the_documented_simulation_runs() {
    let simulation: Simulation = toml::from_str(&block("simulation.toml")).unwrap();
    assert_eq!((simulation.faults.len(), simulation.output_noise.len()), (2, 2));
    for kind in block("signals.toml").split("\n\n") {
        toml::from_str::<SignalSpec>(kind).unwrap_or_else(|e| panic!("{kind}\n{e}"));
    }
}

#[test]
fn every_known_unit_is_documented() {
    let text = documentation();
    for spelling in KNOWN_UNITS.iter().flat_map(|(names, ..)| names.iter()) {
        assert!(spelling.is_empty() || text.contains(&format!("`{spelling}`")), "{spelling}");
    }
}

#[derive(serde::Deserialize)]
struct Run {
    samples: usize,
    sample_time: f64,
    input: SignalSpec,
    simulation: Simulation,
}

/// The example log is the example model's answer to a documented input with documented noise; it
/// is made again here, number by number.
#[test]
fn the_example_log_is_made_from_the_example_model() {
    let model = LinearModel::read(format!("{ROOT}/examples/turbine.toml")).unwrap();
    let text = std::fs::read_to_string(format!("{ROOT}/examples/turbine-run.toml")).unwrap();
    let run: Run = toml::from_str(&text).unwrap();
    let LinearSystem::Continuous(system) = &model.system else { panic!("continuous") };
    let ts = fd_model::SampleTime::new(run.sample_time).unwrap();
    let plant = system.sample_zoh(ts).unwrap().freeze::<f64, fd_core::Heap>().unwrap();
    let channel = model.input_channels().remove(0);
    let inputs = Inputs::from_signals([(channel, run.input)], run.samples, ts).unwrap();
    let deviations = run.simulation.run(&plant, &inputs, model.output_channels()).unwrap();
    let (inputs, outputs) = (model.input_channels(), model.output_channels());
    let record = deviations.unscaled(&model.scaling(), &inputs, &outputs).unwrap();
    let path = format!("{ROOT}/examples/turbine-run.csv");
    if std::env::var_os("FDIAG_WRITE_EXAMPLES").is_some() {
        crate::write_log(&path, &record).unwrap();
    }
    let mut made = Vec::new();
    write_log_to("turbine-run.csv", &mut made, &record).unwrap();
    assert!(made.len() < 100_000);
    let stored = read_log(&path, &LogMap::for_model(&model)).unwrap().record;
    assert_eq!(stored.len(), record.len());
    for (a, b) in stored.samples().zip(record.samples()) {
        for (a, b) in a.0.iter().chain(a.1).zip(b.0.iter().chain(b.1)) {
            // Sines and matrix exponentials differ between machines by a few roundings of
            // values up to 1e4.
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}

#[test]
fn one_run_and_one_stretch_out_of_a_file_of_many() {
    let csv = "run,time_s,position_rad\n3,0,1\n2,1,oops\n3,1,2\n,2,3\n3,2,4\n3,5,5\n3,6,6\n";
    let mut map: LogMap = toml::from_str(&block("rows.toml")).unwrap();
    let read = |map: &LogMap| read_log_from("runs.csv", csv.as_bytes(), map);
    let record = read(&map).unwrap().record;
    assert_eq!((record.len(), record.y(0)[0], record.y(1)[0]), (2, 2.0, 4.0));

    map.rows[0].equals = Some(4.0);
    let message = read(&map).unwrap_err().to_string();
    assert!(message.contains("found none") && message.contains("`run = 4`"), "{message}");
    map.rows[0].column = "runs".to_owned();
    assert!(read(&map).unwrap_err().to_string().contains("did you mean `run`?"));
}

#[test]
fn rows_by_a_number_that_is_computed() {
    let csv = "t,vx,vy [mm/s],y\n0,0.1,0,1\n5,0.1,0,2\n6,0.3,400,3\n7,,400,4\n8,0.3,400,5\n9,0.3,0,6\n10,0.3,0,7\n";
    let mut map: LogMap = toml::from_str(&block("moving.toml")).unwrap();
    let read = |map: &LogMap| read_log_from("runs.csv", csv.as_bytes(), map);
    let record = read(&map).unwrap().record;
    // From 6 s on, faster than 0.2 m/s; one row has no speed, and is a hole in an even grid of 1 s.
    assert_eq!((record.len(), record.y(0)[0], record.y(2)[0], record.y(3)[0]), (5, 3.0, 5.0, 6.0));

    let mut said = |expression: &str, from: Option<f64>, column: &str| {
        map.rows.truncate(1);
        map.rows[0] = RowRule { from, column: column.to_owned(), ..RowRule::computed(expression) };
        read(&map).unwrap_err().to_string()
    };
    let wrong = said("2*vxx", Some(1.0), "");
    assert!(wrong.contains("`rows`: expression: `vxx`") && wrong.contains("mean `vx`"), "{wrong}");
    assert!(said("2*vx", None, "").contains("expected `equals`, `from` or `until`"));
    assert!(said("2*vx", Some(1.0), "vx").contains("found a `column` beside it"));
    assert!(said("1/(t - 5)", Some(1.0), "").contains("row 3: expected a finite number"));
    assert!(said("vx", Some(9.0), "").contains("found none"));
    map.time.sample_time = Some(1.0);
    map.time.column = None;
    map.rows = vec![RowRule { from: Some(2.0), ..RowRule::computed("t") }];
    // Without a column of time all rows of the file are counted.
    let record = read(&map).unwrap().record;
    assert_eq!((record.len(), record.time(0), record.y(0)[0]), (5, 2.0, 3.0));
    map.rows = vec![RowRule { from: Some(0.2), ..RowRule::computed("vx") }];
    assert_eq!(read(&map).unwrap().record.len(), 4);
}

#[test]
fn the_documented_merge_is_a_map() {
    let map: LogMap = toml::from_str(&block("clocks.toml")).unwrap();
    assert_eq!(map.merge.clock.as_deref(), Some("/joint_states"));
    assert_eq!((map.inputs.len(), map.outputs.len(), map.merge.max_age_s), (1, 1, Some(0.05)));
}
