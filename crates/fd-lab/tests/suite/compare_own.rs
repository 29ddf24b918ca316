//! Plants of one's own in the comparison: faults are where the file says, the same road as the engine's, and the shipped
//! configurations run.
#![allow(clippy::unwrap_used, reason = "tests panic to fail")]

use std::{fs, path::Path};

use fd_lab::compare::{CompareConfig, CompareError, Comparison, begin_anew};
use fdiag::spec::ModelSource;

/// A tank with an outflow; the model has another one than the plant.
const TANK: &str = r#"
version = 1
kind = "equations"
name = "tank"
sample_time = 1.0
[parameters]
a = { unit = "1", value = 0.2, tolerance = 0.05 }
[inputs]
q = { unit = "m^3/s" }FAULTS
[states]
h = { unit = "m", initial = 1.0, derivative = "q - LEAK - a*sqrt(max(h, 0))" }
[outputs]
level = { unit = "m", value = "h + OFFSET", noise = 0.002 }
"#;

fn config() -> CompareConfig {
    let model = TANK.replace("FAULTS", "").replace("LEAK", "0").replace("OFFSET", "0");
    let inputs = "\nleak = { unit = \"1\" }\noffset = { unit = \"m\" }";
    let plant = TANK.replace("FAULTS", inputs).replace("LEAK", "leak*sqrt(max(h, 0))");
    let plant = plant.replace("OFFSET", "offset");
    let text = format!(
        r#"
false_alarms = 0.05
sample_time_s = 1.0
settle_s = 60.0
training = {{ duration_s = 600.0 }}
fresh = {{ duration_s = 400.0 }}
faults = {{ start_s = 200.0 }}
engines = {{ thresholds = 2, test = 2, calibration_runs = 3, threshold_runs = 10, test_runs = 4, fault_runs = 2 }}
generators = [{{ name = "simulation", spec = {{ kind = "simulation" }} }}]
biases = [{{ name = "none" }}]
detectors = [{{ name = "largest", spec = {{ kind = "n-sigma", sigmas = 3.0 }} }}]

[[scenarios]]
name = "tank"
[scenarios.own]
model.text = '''{model}'''
plant.text = '''{plant}'''
at = {{ q = 0.2 }}
changes = {{ q = 0.02, h = 0.1, level = 0.1 }}
before_s = 100.0
signals.q = {{ kind = "staircase", low = 0.18, high = 0.22, hold_min_s = 20.0, hold_max_s = 90.0, seed = 1 }}
[[scenarios.own.faults]]
input = "leak"
unit = "m^2"
sizes = {{ smallest = 1e-4, largest = 0.1, count = 4 }}
[[scenarios.own.faults]]
input = "offset"
name = "sensor offset"
sensor = "level"
unit = "m"
sizes = {{ smallest = 1e-4, largest = 1.0, count = 5 }}
"#
    );
    text.parse().unwrap()
}

#[test]
fn large_faults_are_found_and_small_ones_are_not() {
    let config = config();
    let comparison = Comparison::run(&config, None, &()).unwrap();
    let scenario = &comparison.scenarios[0];
    assert_eq!(scenario.outputs, ["level"]);
    assert!(scenario.failed.is_empty(), "{:?}", scenario.failed);
    let entry = &scenario.entries[0];
    assert_eq!(entry.false_alarms.of, 8);
    for (k, (fault, kind)) in entry.faults.iter().zip(&scenario.faults).enumerate() {
        let last = kind.sizes.len() - 1;
        // An outflow half as large again, and ten times an ordinary change of the level, against 5 % of the outflow and
        // noise of .002.
        assert!(entry.found(k, last) > 0.99, "{fault:?}");
        // A thousandth of the outflow and a twentieth of the noise.
        assert!(entry.found(k, 0) < 0.5, "{fault:?}");
        let smallest = fault.smallest.unwrap();
        assert!(kind.sizes[0] < smallest && smallest < kind.sizes[last], "{fault:?}");
    }
    let page = comparison.markdown("fdiag-lab compare");
    assert!(page.contains("leak abrupt [m^2] | sensor offset [m] |"), "{page}");
    assert!(!page.contains("Left out"), "{page}");
    // Half of the engines behind the numbers is not what the reader would think.
    let mut halved = comparison.clone();
    halved.scenarios[0].entries[0].failed_engines = 1;
    let page = halved.markdown("fdiag-lab compare");
    assert!(page.contains("Left out: 1 of the 2 engines that were to be counted, by"), "{page}");
    // Nor is a threshold of half of the engines.
    halved.scenarios[0].entries[0].failed_threshold_engines = 1;
    let page = halved.markdown("fdiag-lab compare");
    assert!(
        page.contains("to be counted, and 1 of the 2 engines that were to set thresholds"),
        "{page}"
    );
    // The same numbers whatever else runs beside.
    let mut again = Comparison::run(&config, None, &()).unwrap();
    again.overall.iter_mut().zip(&comparison.overall).for_each(|(a, b)| a.cost_ns = b.cost_ns);
    assert_eq!(again, comparison);
}

#[test]
fn a_comparison_does_not_go_on_with_another_model_file() {
    let directory = tempfile::tempdir().unwrap();
    let journal = directory.path().join("progress.jsonl");
    let mut config = config();
    let own = config.scenarios[0].own.as_mut().unwrap();
    // Both files as files; the model is also that of a filter, whose file counts as well.
    for (name, source) in [("model.toml", &mut own.model), ("plant.toml", &mut own.plant)] {
        let ModelSource::Text { text } = source else { panic!("a file") };
        fs::write(directory.path().join(name), text).unwrap();
        *source = ModelSource::File(name.into());
    }
    let filter = r#"{ kind = "extended", model = "filter.toml", process_noise = 1e-3 }"#;
    fs::copy(directory.path().join("model.toml"), directory.path().join("filter.toml")).unwrap();
    let filter =
        format!("generators = [{{ name = \"filter\", spec = {filter} }}]").parse::<CompareConfig>();
    config.generators.append(&mut filter.unwrap().generators);
    config.begin_in(directory.path());

    let run = || Comparison::run(&config, Some(&journal), &());
    let begun = run().unwrap();
    // Finished engines count as long as the files are the same.
    let lines = || fs::read_to_string(&journal).unwrap().lines().count();
    let finished = lines();
    // As text, since a share of nothing is NaN, which equals nothing.
    let shown = |comparison: &Comparison| format!("{:?}", comparison.scenarios);
    assert_eq!(shown(&run().unwrap()), shown(&begun));
    assert_eq!(lines(), finished);
    for name in ["model.toml", "plant.toml", "filter.toml"] {
        let path = directory.path().join(name);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replace("value = 0.2,", "value = 0.21,")).unwrap();
        let error = run().unwrap_err();
        assert!(
            matches!(&error, CompareError::ChangedFile { file, .. } if *file == path),
            "{error}"
        );
        assert!(error.to_string().contains("--restart"), "{error}");
        assert_eq!(lines(), finished, "nothing is written");
        fs::write(&path, text).unwrap();
    }
    // Begun anew, it takes the file as it is.
    let path = directory.path().join("plant.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("value = 0.2,", "value = 0.21,")).unwrap();
    begin_anew(&journal).unwrap();
    assert_ne!(shown(&run().unwrap()), shown(&begun));
}

#[test]
fn what_does_not_fit_is_named() {
    let refused = |change: fn(&mut CompareConfig)| {
        let mut config = config();
        change(&mut config);
        Comparison::run(&config, None, &()).unwrap_err().to_string()
    };
    let message = refused(|config| {
        let own = config.scenarios[0].own.as_mut().unwrap();
        own.faults[0].input = "leek".to_owned();
    });
    assert!(message.contains("`tank`") && message.contains("leek"), "{message}");
    let message = refused(|config| {
        config.scenarios[0].own.as_mut().unwrap().changes.remove("h");
    });
    assert!(message.contains("changes") && message.contains("`h`"), "{message}");
    let message = refused(|config| {
        let own = config.scenarios[0].own.as_mut().unwrap();
        own.at.insert("w".to_owned(), 1.0);
    });
    assert!(message.contains("`w`"), "{message}");
    let message = refused(|config| {
        let own = config.scenarios[0].own.as_mut().unwrap();
        own.faults[1].sensor = Some("flow".to_owned());
    });
    assert!(message.contains("`flow`"), "{message}");
    // A tank that is always filled finds no rest.
    let message = refused(|config| {
        let own = config.scenarios[0].own.as_mut().unwrap();
        own.at.insert("q".to_owned(), -1.0);
    });
    assert!(message.contains("no rest"), "{message}");
    let message = refused(|config| {
        config.scenarios[0].own.as_mut().unwrap().faults[1].sizes.smallest = 0.0;
    });
    assert!(message.contains("faults.sizes") && message.contains("0 to 1, 5 sizes"), "{message}");
    let message = refused(|config| config.scenarios[0].own.as_mut().unwrap().faults.clear());
    assert!(message.contains("faults: expected at least one"), "{message}");
    // Refused before anything of that size is made.
    let message = refused(|config| config.scenarios[0].own.as_mut().unwrap().before_s = 1e12);
    assert!(message.contains("limit `samples`"), "{message}");
    let message = refused(|config| config.training.duration_s = 0.0);
    assert!(message.contains("training.duration_s"), "{message}");
}

/// The shipped plants: one generator, few runs.
#[test]
fn shipped_configurations_run() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/plants");
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let folder = entry.unwrap().path();
        let text = fs::read_to_string(folder.join("compare.toml")).unwrap();
        let mut config: CompareConfig = text.parse().unwrap();
        config.begin_in(&folder);
        config.check().unwrap();
        config.generators.truncate(1);
        config.biases.truncate(1);
        (config.engines.thresholds, config.engines.test) = (1, 1);
        (config.engines.threshold_runs, config.engines.test_runs) = (19, 1);
        for scenario in &mut config.scenarios {
            let faults = &mut scenario.own.as_mut().unwrap().faults;
            for fault in faults {
                (fault.sizes.smallest, fault.sizes.count) = (fault.sizes.largest, 1);
            }
        }
        let comparison = Comparison::run(&config, None, &()).unwrap();
        let scenario = &comparison.scenarios[0];
        assert!(scenario.failed.is_empty(), "{}: {:?}", folder.display(), scenario.failed);
        let found: u64 = scenario.entries[0].faults.iter().map(|fault| fault.found[0]).sum();
        assert!(found > 0, "{}: nothing found", folder.display());
        // What costs time is there without a bias model as well.
        assert!(comparison.overall.iter().all(|entry| entry.cost_ns.is_some_and(|ns| 0.0 < ns)));
        count += 1;
    }
    assert_eq!(count, 7);
}
