//! Model files: examples, printing, mistakes.

use std::path::{Path, PathBuf};

use fd_sim::{
    model::{LoadError, Mistake, Model},
    simulate::{EquationSimulator, OperatingPoint, Outcome, Simulator, linearize},
};

const EXAMPLES: [&str; 9] = [
    "mass_spring_damper",
    "dc_drive",
    "dc_drive_closed_loop",
    "pendulum",
    "cart_pole",
    "two_mass_drive",
    "tanks",
    "two_input",
    "two_spool_engine",
];

pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn example(name: &str) -> Model {
    Model::load(&root().join(format!("examples/models/{name}.toml"))).unwrap()
}

/// The model at rest under constant inputs: where it is after a long time.
fn rest(model: &Model, u: &[f64]) -> Vec<f64> {
    let mut simulator = EquationSimulator::<f64>::new(model).unwrap();
    simulator.start(&model.nominal(), &model.initial(), 0);
    let mut y = vec![0.0; model.outputs.len()];
    for _ in 0..20_000 {
        simulator.step(u, u, &[], &mut y);
    }
    simulator.state().to_vec()
}

fn working_input(name: &str) -> Vec<f64> {
    match name {
        "mass_spring_damper" => vec![4.0],
        "dc_drive" => vec![12.0],
        "dc_drive_closed_loop" => vec![150.0],
        "pendulum" => vec![1.0],
        "cart_pole" => vec![2.0],
        "two_mass_drive" => vec![0.5],
        "tanks" => vec![5.5],
        "two_input" => vec![8e-5, 1e-4],
        "two_spool_engine" => vec![0.1, 0.05],
        other => panic!("no input for {other}"),
    }
}

#[test]
fn every_file_in_the_directory_is_tested() {
    let mut found: Vec<String> = std::fs::read_dir(root().join("examples/models"))
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    found.sort();
    let mut expected = EXAMPLES.to_vec();
    expected.sort_unstable();
    assert_eq!(found, expected);
}

#[test]
fn examples_print_to_themselves() {
    for name in EXAMPLES {
        let model = example(name);
        let text = model.to_string();
        let again: Model = text.parse().unwrap();
        assert_eq!(again, model, "{name}");
        assert_eq!(again.to_string(), text, "{name}");
    }
}

#[test]
fn examples_are_stable_where_they_come_to_rest() {
    for name in EXAMPLES {
        let model = example(name);
        let u = working_input(name);
        let x = rest(&model, &u);
        assert!(x.iter().all(|value| value.is_finite()), "{name}: {x:?}");
        if name == "dc_drive_closed_loop" {
            // A sampled loop has no continuous linear model: it rests at its reference instead.
            assert!((x[1] - 150.0).abs() < 1e-6, "{name}: {x:?}");
            continue;
        }
        let at = OperatingPoint { x: x.clone(), u, ..OperatingPoint::initial(&model) };
        let linear = linearize(&model, &at).unwrap();
        assert!(linear.is_stable().unwrap(), "{name}: {:?}", linear.poles());
        let known = match name {
            "mass_spring_damper" => Some((0, 4.0 / 80.0)),
            "pendulum" => Some((0, (1.0_f64 / (9.81 * 0.5)).asin())),
            "dc_drive" => Some((1, 12.0 * 0.05 / (0.05 * 0.05 + 0.6 * 5e-5))),
            "cart_pole" => Some((0, 2.0 / 5.0)),
            "two_mass_drive" => Some((0, 0.5 / (0.01 + 0.015))),
            _ => None,
        };
        if let Some((state, value)) = known {
            assert!(
                (x[state] - value).abs() < 1e-6 * value.abs(),
                "{name}: {x:?}, expected {value}"
            );
        }
    }
}

#[test]
fn a_linearised_model_follows_small_signals() {
    for name in EXAMPLES.into_iter().filter(|name| *name != "dc_drive_closed_loop") {
        let model = example(name);
        let u = working_input(name);
        let x = rest(&model, &u);
        let at = OperatingPoint { x: x.clone(), u: u.clone(), ..OperatingPoint::initial(&model) };
        let linear =
            linearize(&model, &at).unwrap().sample_zoh(model.sample_time().unwrap()).unwrap();

        // A step of a millionth of each input: what is left over is of second order.
        for channel in 0..u.len() {
            let du = 1e-4 * u[channel];
            let mut stepped = u.clone();
            stepped[channel] += du;
            let (mut dx, mut y0) = (vec![0.0; x.len()], vec![0.0; model.outputs.len()]);
            let mut y = y0.clone();
            let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
            simulator.start(&model.nominal(), &x, 0);
            simulator.step(&u, &u, &[], &mut y0);
            simulator.start(&model.nominal(), &x, 0);
            let (mut worst, mut size) = (vec![0.0_f64; y.len()], vec![0.0_f64; y.len()]);
            for _ in 0..300 {
                simulator.step(&stepped, &stepped, &[], &mut y);
                for row in 0..y.len() {
                    let expected: f64 =
                        (0..dx.len()).map(|j| linear.c()[(row, j)] * dx[j]).sum::<f64>()
                            + linear.d()[(row, channel)] * du;
                    worst[row] = worst[row].max((y[row] - y0[row] - expected).abs());
                    size[row] = size[row].max(expected.abs());
                }
                dx = (0..dx.len())
                    .map(|i| {
                        (0..dx.len()).map(|j| linear.a()[(i, j)] * dx[j]).sum::<f64>()
                            + linear.b()[(i, channel)] * du
                    })
                    .collect();
            }
            for row in 0..y.len() {
                // Relative: 1e-4 of second order, 1e-4 of integration.
                assert!(
                    worst[row] <= 5e-4 * size[row] + 1e-9,
                    "{name}, {channel} to {row}: {worst:?} of {size:?}"
                );
            }
        }
    }
}

#[test]
fn examples_run_through_a_test_signal() {
    for name in EXAMPLES {
        let model = example(name);
        let base = working_input(name);
        let samples = 1000;
        let u: Vec<f64> = (0..samples)
            .flat_map(|k| {
                let wave = if (k / 60) % 2 == 0 { 1.2 } else { 0.4 };
                base.iter().map(move |value| value * wave).collect::<Vec<_>>()
            })
            .collect();
        let mut y = vec![0.0; samples * model.outputs.len()];
        let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
        let outcome =
            Simulator::simulate(&mut simulator, &model.nominal(), &model.initial(), &u, &mut y);
        assert_eq!(outcome, Outcome::Complete, "{name}");

        // Half the step changes the outputs by less than a fifth of the sensor noise.
        let mut fine = vec![0.0; y.len()];
        let mut refined = simulator.refined(2);
        Simulator::simulate(&mut refined, &model.nominal(), &model.initial(), &u, &mut fine);
        let ny = model.outputs.len();
        for (k, (a, b)) in y.iter().zip(&fine).enumerate() {
            let noise = model.outputs[k % ny].noise.unwrap();
            assert!((a - b).abs() < 0.2 * noise, "{name}, sample {}: {a} against {b}", k / ny);
        }
    }
}

const GOOD: &str = r#"
version = 1
kind = "equations"
name = "lag"
sample_time = 0.1
[parameters]
T = { unit = "s", value = 2.0 }
[inputs]
u = { unit = "1", saturation = [-1, "2*T"] }
[states]
x = { unit = "1", initial = 0.0, derivative = "(u - x)/T" }
[outputs]
y = { unit = "1", value = "x" }
"#;

fn mistake(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from));
    GOOD.replace(from, to).parse::<Model>().unwrap_err().to_string()
}

#[test]
fn mistakes_are_named_with_their_place() {
    assert!(GOOD.parse::<Model>().is_ok());
    let cases = [
        (
            "(u - x)/T",
            "(u - x)/)",
            "11:56: states.x.derivative: expected a number or name, found `)`\n    (u - x)/)\n            ^",
        ),
        (
            "(u - x)/T",
            "(u - x)/Tau",
            "11:56: states.x.derivative: `Tau` is not known here\n    (u - x)/Tau\n            ^^^",
        ),
        (
            "(u - x)/T",
            "(u-x) /Tau",
            "11:55: states.x.derivative: `Tau` is not known here\n    (u-x) /Tau\n           ^^^",
        ),
        (
            "\"(u - x)/T\"",
            "'''\n  (u - x)\n    /Tau'''",
            "13:6: states.x.derivative: `Tau` is not known here\n        /Tau\n         ^^^",
        ),
        (
            "(u - x)/T",
            "(u - x)/t_1",
            "11:56: states.x.derivative: `t_1` is not known here\n    (u - x)/t_1\n            ^^^",
        ),
        (
            "\"2*T\"",
            "\"2*x\"",
            "9:40: inputs.u.saturation: `x` is a state of the plant and cannot be used here, only parameters and `pi`\n    2*x\n      ^",
        ),
        (
            "value = \"x\"",
            "value = \"tanh2(x)\"",
            "13:28: outputs.y.value: there is no function or table `tanh2`; did you mean `tanh`?",
        ),
        (
            "value = \"x\"",
            "value = \"y\"",
            "13:28: outputs.y.value: `y` is an output and cannot be used here, only parameters, inputs, states, definitions, delays, signs, `pi`, `t`, `dt` and `first`\n    y\n    ^",
        ),
        (
            "x = { unit",
            "T = { unit",
            "11:1: states.T: the name `T` is already given to parameters.T",
        ),
        ("x = { unit", "sin = { unit", "11:1: states.sin: `sin` cannot be a name"),
        (
            "value = 2.0",
            "value = nan",
            "7:1: parameters.T.value: the value must be finite, got NaN",
        ),
        (
            "sample_time = 0.1",
            "sample_time = 0.0",
            "5:15: sample_time: the sample time in seconds must be positive and finite, got 0",
        ),
        (
            "unit = \"s\"",
            "unit = \" \"",
            "7:1: parameters.T.unit: a unit is needed, `1` for a pure number",
        ),
        ("derivative", "derivate", "11:34: unknown field `derivate`"),
        (
            ", derivative = \"(u - x)/T\"",
            "",
            "11:1: states.x: exactly one of `derivative` and `update` is needed",
        ),
        (
            "version = 1",
            "version = 2",
            "version: this is format version 2, this program reads version 1",
        ),
        ("equations", "linear", "kind: this is a model of kind `linear`, expected `equations`"),
        (
            "value = 2.0",
            "value = 2.0, bounds = [3.0, 4.0]",
            "7:1: parameters.T.bounds: the value must be between the bounds",
        ),
        ("sample_time = 0.1", "sample_time = ", "5:"),
    ];
    for (from, to, expected) in cases {
        let found = mistake(from, to);
        assert!(found.starts_with(expected), "{to}:\n{found}\nexpected\n{expected}");
    }
}

#[test]
fn circles_and_algebraic_loops_are_found() {
    let circle = GOOD.to_owned() + "[definitions]\na = \"b + 1\"\nb = \"2*a\"\n";
    let error = circle.parse::<Model>().unwrap_err();
    assert_eq!(*error.mistake, Mistake::Cycle(vec!["a".into(), "b".into(), "a".into()]));

    let looped =
        GOOD.replace("value = \"x\"", "value = \"x + u\"") + "[controller.signals]\nu = \"-y\"\n";
    let error = looped.parse::<Model>().unwrap_err();
    assert!(error.to_string().contains("y → u → y"), "{error}");
}

#[test]
fn a_missing_file_is_named() {
    let error = Model::load(Path::new("no/such/model.toml")).unwrap_err();
    assert!(
        matches!(&error, LoadError::Read { file, .. } if file == "no/such/model.toml"),
        "{error}"
    );
}

#[test]
fn the_example_of_the_manual_is_a_model() {
    let manual = std::fs::read_to_string(root().join("docs/model-equations.md")).unwrap();
    let blocks: Vec<&str> = manual
        .split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap())
        .filter(|block| block.contains("version = 1"))
        .collect();
    assert!(!blocks.is_empty());
    for block in blocks {
        let model: Model = block.parse().unwrap_or_else(|error| panic!("{error}"));
        let u = vec![0.1; 100 * model.external_inputs().len()];
        let mut y = vec![0.0; 100 * model.outputs.len()];
        let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
        assert_eq!(
            Simulator::simulate(&mut simulator, &model.nominal(), &model.initial(), &u, &mut y),
            Outcome::Complete
        );
        assert_eq!(model.to_string().parse::<Model>().unwrap(), model);
    }
}

#[test]
fn all_mistakes_of_a_file_are_said_at_once() {
    let file = |x: &str, v: &str, y: &str| {
        format!(
            "version = 1\nkind = \"equations\"\nname = \"m\"\nsample_time = 0.1\n[inputs]\nP = {{ unit = \"W\" }}\n\
             [states]\nx = {{ unit = \"1\", initial = 0.0, derivative = \"{x}\" }}\n\
             v = {{ unit = \"1\", initial = 0.0, derivative = \"{v}\" }}\n[outputs]\ny = {{ unit = \"1\", value = \"{y}\" }}\n"
        )
    };
    let said = |text: &str| text.parse::<Model>().unwrap_err().to_string();
    // Expressions that are none, and names that nobody knows.
    for (x, v, y, parts) in [
        ("(P - x", "P +", "x", ["states.x.derivative: expected `)`", "9:", "states.v.derivative"]),
        (
            "P*b",
            "v",
            "z",
            ["states.x.derivative: `b` is not known", "11:", "outputs.y.value: `z` is not known"],
        ),
    ] {
        let error = said(&file(x, v, y));
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
    assert!(!said(&file("P*b", "v", "x")).contains("outputs"));
}
