//! The jet engine as a model file.

use std::fs;

use crate::gap::desk::{Desk, refuses, stdout};

/// A folder with the engine and two of its logs.
fn engine() -> Desk {
    let desk = Desk::of("engine", &["engine.toml", "linear.toml", "valve.csv", "worn.csv"]);
    fs::rename(desk.path("valve.csv"), desk.path("monday.csv")).unwrap();
    desk
}

/// A part of the effects, to be quick.
const FEW: [&str; 6] = ["--only", "input-lag", "--only", "sensor-bias@P_6", "--only", "bleed-leak"];

#[test]
fn a_slow_fuel_valve_is_found_by_the_linear_engine() {
    let desk = engine();
    let model = ["--model", "linear.toml", "--log", "monday.csv", "--out", "out"];
    let output = desk.run(&[&model[..], &FEW].concat());
    assert!(output.status.success(), "{output:?}");
    let report = desk.report();
    let first = &report["diagnosis"]["causes"][0];
    assert_eq!((&first["label"], &first["site"]["name"]), (&"input-lag".into(), &"W_f".into()));
    // The valve of the log has 0.15 s; the linear engine is wrong by more than the standard error.
    let lag = first["parameters"][0]["value"].as_f64().unwrap();
    assert!((lag - 0.15).abs() < 0.015, "{lag}");
    // What the engine has no place for is said not to be tested, and friction is no effect of it.
    let output = desk.run(&[&model[..], &["--only", "friction"]].concat());
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    // Its patched model is equations, and runs.
    let again = ["--model", "out/patched.toml", "--log", "monday.csv", "--out", "again"];
    let output = desk.run(&[&again[..], &["--only", "input-delay"]].concat());
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn a_slow_fuel_valve_is_found_by_the_nonlinear_engine_and_patched_into_it() {
    let desk = engine();
    // Twelve seconds show it as well as the 24 s of the example.
    let log = desk.read("monday.csv");
    let half: Vec<&str> = log.lines().take(301).collect();
    fs::write(desk.path("monday.csv"), half.join("\n") + "\n").unwrap();
    let model = ["--model", "engine.toml", "--log", "monday.csv", "--out", "out"];
    let output = desk.run(&[&model[..], &FEW, &["--tolerance", "hpc_flow=0"]].concat());
    assert!(output.status.success(), "{output:?}");
    let report = desk.report();
    assert_eq!(report["diagnosis"]["verdict"], "cause", "{}", report["headline"]);
    let first = &report["diagnosis"]["causes"][0];
    assert_eq!((&first["label"], &first["site"]["name"]), (&"input-lag".into(), &"W_f".into()));
    let lag = &first["parameters"][0];
    let (value, error) = (lag["value"].as_f64().unwrap(), lag["standard_error"].as_f64().unwrap());
    // Three standard errors, those of the whole log at most, and a hundredth for the steps of the integration.
    let error = error.min(0.0022);
    assert!((value - 0.15).abs() < 3.0 * error + 0.0015, "{value} {error}");
    let closed =
        report["diagnosis"]["held_out"][0]["closed_of_refit"]["fraction"].as_f64().unwrap();
    assert!(0.9 < closed, "{closed}");
    let refitted = report["diagnosis"]["best"]["nuisances"].as_array().unwrap();
    assert!(refitted.iter().all(|nuisance| nuisance["name"] != "hpc_flow"));
    // Nothing of the shell is a place of the engine.
    let places = report["location"]["places"].to_string();
    assert!(!places.contains("_raw") && !places.contains("_integral"), "{places}");
    // The file is the engine with the valve in it: no gap is left.
    let text = desk.read("out/patched.toml");
    assert!(text.contains("kind = \"engine17\"") && text.contains("sample_time = 0.04"), "{text}");
    let again = ["--model", "out/patched.toml", "--log", "monday.csv", "--out", "again"];
    let output = desk.run(&[&again[..], &["--only", "input-lag"]].concat());
    assert!(output.status.success(), "{output:?}");
    let second = desk.report_in("again");
    assert_eq!(second["diagnosis"]["verdict"], "no-gap", "{}", second["headline"]);
    for (a, b) in report["location"]["channels"]
        .as_array()
        .unwrap()
        .iter()
        .zip(second["location"]["channels"].as_array().unwrap())
    {
        let (after, before) = (a["after"]["value"].as_f64(), b["nominal"]["value"].as_f64());
        // The same simulation of the same log.
        let (after, before) = (after.unwrap(), before.unwrap());
        assert!((after - before).abs() < 1e-9 * after, "{after} {before}");
    }
}

#[test]
fn engines_that_do_not_exist_are_refused() {
    let desk = engine();
    let good = desk.read("engine.toml");
    let outputs = "outputs = [\"N_L\", \"N_H\", \"T_7\", \"P_6\", \"T_29\"]";
    for (from, to, parts) in [
        ("version = 1", "version = 2", &["engine.toml", "version", "found `2`"][..]),
        ("fuel_flow = 0.712", "fuel_flow = -1.0", &["fuel_flow", "kg/s above 0", "`-1`"]),
        ("fuel_flow = 0.712", "fuel_flow = 25.0", &["engine.toml: "]),
        (
            "fuel_flow = 0.712",
            "fuel = 0.712",
            &["engine.toml", "unknown field `fuel`", "fuel_flow"],
        ),
        ("step = 0.0067", "step = 0.5", &["step", "0.008", "`0.5`"]),
        (outputs, "outputs = [\"N_L\", \"T_4\"]", &["outputs", "`T_7`", "T_4"]),
        (outputs, "outputs = [\"N_L\", \"N_L\"]", &["outputs", "each once"]),
        ("modules = 0.002", "modules = 2.0", &["tolerances", "below 1", "2"]),
        ("N_L = 3.6", "N_L = 0.0", &["noise", "above 0", "N_L = 0"]),
        ("simulator = \"nonlinear\"", "simulator = \"cubic\"", &["cubic", "nonlinear", "linear"]),
    ] {
        assert!(good.contains(from), "{from}");
        desk.put("engine.toml", &good.replace(from, to));
        let output = desk.run(&["--model", "engine.toml", "--log", "monday.csv", "--out", "out"]);
        refuses(&desk, &output, 3, parts);
    }
    desk.put("engine.toml", &good);
    let output = desk.run(&["--model", "engine.toml", "--print-model", "--log", "monday.csv"]);
    let text = stdout(&output);
    assert!(text.contains("kind = \"engine17\"") && text.contains("hpc_efficiency"), "{text}");
}
