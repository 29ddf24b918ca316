//! Definitions that are used in many places, and models that would cost too much.

use std::fmt::Write;

use fd_sim::{
    equation::{Definitions, Expr, Size},
    model::{Mistake, Model},
    scales::ReplayScales,
    simulate::{EquationSimulator, SimulateError, Simulator},
};

/// A mass of 2 kg of which the site sees the velocity through definitions.
fn cart(definitions: &str, velocity: &str, derivative: &str) -> Model {
    let text = format!(
        r#"
        version = 1
        kind = "equations"
        name = "cart"
        sample_time = 0.01
        parameters = {{ m = {{ unit = "kg", value = 2.0 }} }}
        inputs = {{ u = {{ unit = "N" }} }}
        outputs = {{ y = {{ unit = "m/s", value = "v" }} }}
        states = {{ v = {{ unit = "m/s", initial = 0.0, derivative = "{derivative}" }} }}
        sites = {{ rail = {{ unit = "N", enters = {{ v = "1/m" }}, velocity = "{velocity}" }} }}
        [definitions]
        {definitions}
        "#
    );
    text.parse().unwrap()
}

fn chain(length: usize, link: impl Fn(&str) -> String) -> String {
    let mut text = "c0 = \"v\"\n".to_owned();
    for k in 1..=length {
        writeln!(text, "c{k} = \"{}\"", link(&format!("c{}", k - 1))).unwrap();
    }
    text
}

fn scales(model: &Model) -> ReplayScales {
    let u: Vec<f64> = (0..50).map(|k| if k % 20 < 10 { 3.0 } else { -1.0 }).collect();
    ReplayScales::of(model, model.sample_time().unwrap(), &u, 50).unwrap()
}

#[test]
fn twenty_two_doublings_are_no_four_million_terms() {
    let model = cart(&chain(22, |c| format!("{c} + {c}")), "c22", "u/m");
    let named = model.definitions.iter().map(|d| (d.name.as_str(), &d.value));
    let size = Definitions::new(named).size(&Expr::name("c22")).unwrap();
    assert_eq!(size, Size { nodes: (1 << 23) - 1, levels: 23 });

    let site = &scales(&model).sites[0];
    assert!(!site.helpers.is_empty());
    // Sums of equal numbers and a quotient by 2 are exact.
    assert_eq!(site.mobility, f64::from(1 << 22) / 2.0);
    assert!((site.force - 2.0).abs() < 0.2, "half of the time 3 N, half -1 N: {}", site.force);
}

#[test]
fn five_thousand_definitions_in_a_row_are_no_depth() {
    let model = cart(&chain(5_000, |c| format!("{c} + 1e-4*{c}")), "c5000", "(u - c5000)/m");
    let site = &scales(&model).sites[0];
    let factor = 1.0001_f64.powi(5_000);
    // Five thousand roundings of 1.1e-16 each.
    assert!((site.mobility - factor / 2.0).abs() < 1e-12 * factor, "{}", site.mobility);
    let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
    let mut y = vec![0.0; 400];
    simulator.simulate(&model.nominal(), &model.initial(), &vec![1.0; 400], &mut y);
    // At rest u = c5000.
    assert!((y[399] * factor - 1.0).abs() < 0.05, "{}", y[399] * factor);
}

#[test]
fn what_is_short_is_written_out_as_ever() {
    let model = cart("half = \"0.5*v\"\nw = \"half*half\"", "w", "u/m");
    let site = &scales(&model).sites[0];
    assert!(site.helpers.is_empty());
    assert_eq!(site.acceleration.to_string(), "(0.5*(0.5*v) + 0.5*v*0.5)*(u/m)");
    for file in std::fs::read_dir(super::models::root().join("examples/models")).unwrap() {
        let model = Model::load(&file.unwrap().path()).unwrap();
        let inputs = model.external_inputs().len();
        let ts = model.sample_time().unwrap();
        let scales = ReplayScales::of(&model, ts, &vec![0.1; 20 * inputs], 20).unwrap();
        assert!(scales.sites.iter().all(|site| site.helpers.is_empty()), "{}", model.name);
    }
}

fn refused(text: &str) -> String {
    text.parse::<Model>().unwrap_err().to_string()
}

const LINE: &str = r#"
version = 1
kind = "equations"
name = "line"
sample_time = 0.01
parameters = { T = { unit = "s", value = 0.0 } }
inputs = { u = { unit = "1" } }
outputs = { y = { unit = "1", value = "late" } }
delays = { late = { value = "u", time = "0.1" } }
"#;

#[test]
fn delays_that_are_no_time_or_no_memory_are_refused() {
    for time in ["0/T", "1/T", "-1/T", "sqrt(T - 1)"] {
        let error = refused(&LINE.replace("0.1\"", &format!("{time}\"")));
        let words = "delays.late.time: the delay in seconds, at nominal parameters, must be finite";
        assert!(error.contains(words), "{time}: {error}");
    }
    let long: Model = LINE
        .replace("\"0.1\"", "\"1e9\"")
        .replace("sample_time = 0.01", "sample_time = 0.01\nstep = 0.001")
        .parse()
        .unwrap();
    let error = EquationSimulator::<f64>::new(&long).map(drop).unwrap_err().to_string();
    let words = "delay `late` of 1000000000 s: expected at most 1048576 integration steps (limit \
                 `delay_steps`), found 1000000000000";
    assert_eq!(error, words);
}

#[test]
fn steps_that_are_too_short_are_refused() {
    let text = LINE.replace("sample_time = 0.01", "sample_time = 0.1\nstep = 1e-6");
    let model: Model = text.parse().unwrap();
    let error = EquationSimulator::<f64>::new(&model).map(drop).unwrap_err();
    assert!(matches!(error, SimulateError::TooStiff { most: 10_000, .. }), "{error}");
    assert!(error.to_string().contains("limit `substeps`"), "{error}");
}

#[test]
fn names_and_units_are_what_they_look_like() {
    for (from, to) in [
        ("name = \"line\"", "name = \"a\\u001b[31mb\""),
        ("name = \"line\"", "name = \"a\\nb\""),
        ("u = { unit = \"1\" }", "u = { unit = \"m\\r\" }"),
        ("name = \"line\"", "name = \"line\"\ndescription = \"\\u202etxt\""),
    ] {
        let error = LINE.replace(from, to).parse::<Model>().unwrap_err();
        assert!(matches!(*error.mistake, Mistake::NotPlain(_)), "{to}: {error}");
        assert!(!error.to_string().contains(['\u{1b}', '\r', '\u{202e}']), "{error:?}");
    }
    let name = "q".repeat(257);
    let error = refused(&LINE.replace("T = {", &format!("{name} = {{")));
    assert!(error.contains("cannot be a name") && error.len() < 600, "{error}");
}

#[test]
fn a_million_characters_are_not_echoed() {
    let long = "q".repeat(1_000_000);
    for text in [
        LINE.replace("\"late\" }", &format!("\"u + {long}\" }}")),
        LINE.replace("\"late\" }", &format!("\"u + {long}*/\" }}")),
        LINE.replace("\"late\" }", &format!("\"u + {long}(1, 2)\" }}")),
        LINE.replace("\"late\" }", &format!("\"{}u\" }}", "(".repeat(1_000_000))),
        LINE.replace("\"late\" }", &format!("\"1{}\" }}", "0".repeat(1_000_000))),
        LINE.replace("kind = \"equations\"", &format!("kind = \"{long}\"")),
        LINE.replace("version = 1", &format!("version = 1\n{long} = 1")),
        LINE.replace("delays", &format!("delays.{long}")),
    ] {
        let error = refused(&text);
        assert!(error.len() < 1_500, "{} bytes: {}", error.len(), &error[..300]);
    }
}
