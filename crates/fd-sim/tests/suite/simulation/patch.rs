//! Patches: identity at zero strength, printing, the way they add up.

use std::path::Path;

use fd_sim::{
    equation::Expr,
    model::{Delay, Law, Model, Parameter, State},
    patch::{Patch, PatchError},
    simulate::{EquationSimulator, Simulator},
};
use proptest::prelude::*;

fn example(name: &str) -> Model {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/models");
    Model::load(&root.join(name)).unwrap()
}

fn expr(text: &str) -> Expr {
    Expr::parse(text).unwrap()
}

fn run(model: &Model, u: &[f64]) -> Vec<f64> {
    let mut simulator = EquationSimulator::<f64>::new(model).unwrap();
    let samples = u.len() / model.external_inputs().len();
    let mut y = vec![0.0; samples * model.outputs.len()];
    Simulator::simulate(&mut simulator, &model.nominal(), &model.initial(), u, &mut y);
    y
}

/// An effect of strength `e` of every kind at every place of a model.
fn patches(model: &Model, e: f64) -> Vec<Model> {
    let step = model.sample_time / EquationSimulator::<f64>::new(model).unwrap().substeps() as f64;
    let start = || {
        let mut patch = Patch::of(model);
        patch.add_parameter(Parameter::new("e", "1", e));
        patch.pin_step(step);
        patch
    };
    let mut all = Vec::new();
    for input in &model.inputs {
        let u = &input.name;
        let mut gain = start();
        gain.wrap_input(u, "applied", expr(&format!("(1 + e)*{u}"))).unwrap();
        all.push(gain.finish().unwrap());

        let mut delay = start();
        delay.wrap_input(u, "applied", expr("late")).unwrap();
        delay.add_delay(Delay { name: "late".into(), value: expr(u), time: expr("e") });
        all.push(delay.finish().unwrap());

        // A lag over the held input of a step, exact, and the identity for a time constant of 0.
        let mut lag = start();
        let value = format!("if(e > 0, {u} + (lagged - {u})*(1 - exp(-dt/e))*e/dt, {u})");
        lag.wrap_input(u, "applied", expr(&value)).unwrap();
        lag.add_state(State {
            name: "lagged".into(),
            unit: input.unit.clone(),
            initial: 0.0,
            tolerance: None,
            law: Law::Update(expr(&format!("if(e > 0, {u} + (lagged - {u})*exp(-dt/e), {u})"))),
        });
        all.push(lag.finish().unwrap());
    }
    for output in &model.outputs {
        let mut bias = start();
        bias.wrap_output(&output.name, "measured", expr("measured + e")).unwrap();
        all.push(bias.finish().unwrap());

        let mut delay = start();
        delay.wrap_output(&output.name, "measured", expr("late")).unwrap();
        delay.add_delay(Delay { name: "late".into(), value: expr("measured"), time: expr("e") });
        all.push(delay.finish().unwrap());
    }
    for site in &model.sites {
        let mut friction = start();
        let velocity = site.velocity.clone().unwrap_or_else(|| Expr::name("t"));
        friction.add_force(&site.name, "friction", -expr("e") * velocity).unwrap();
        all.push(friction.finish().unwrap());
    }
    for parameter in &model.parameters {
        let mut error = start();
        let value = expr(&format!("{}*(1 + e)", parameter.name));
        error.wrap_parameter(&parameter.name, "true_value", value).unwrap();
        all.push(error.finish().unwrap());
    }
    all
}

fn signal(model: &Model, samples: usize) -> Vec<f64> {
    let scale = match model.name.as_str() {
        "tanks" => 5.0,
        "two-input" => 1e-4,
        "dc-drive-closed-loop" => 100.0,
        _ => 2.0,
    };
    (0..samples * model.external_inputs().len())
        .map(|k| scale * (1.0 + 0.5 * (0.1 * k as f64).sin()))
        .collect()
}

const MODELS: [&str; 8] = [
    "mass_spring_damper.toml",
    "dc_drive.toml",
    "dc_drive_closed_loop.toml",
    "pendulum.toml",
    "cart_pole.toml",
    "two_mass_drive.toml",
    "tanks.toml",
    "two_input.toml",
];

#[test]
fn zero_strength_is_the_identity() {
    for name in MODELS {
        let model = example(name);
        let u = signal(&model, 200);
        let expected = run(&model, &u);
        for patched in patches(&model, 0.0) {
            // `==`: only the sign of a zero may differ.
            assert_eq!(run(&patched, &u), expected, "{patched}");
        }
    }
}

#[test]
fn a_patched_model_survives_its_file_to_the_bit() {
    for name in MODELS {
        let model = example(name);
        let u = signal(&model, 200);
        let plain = run(&model, &u);
        for patched in patches(&model, 0.013) {
            let printed: Model = patched.to_string().parse().unwrap();
            assert_eq!(printed, patched);
            let y = run(&patched, &u);
            let bits = |y: &[f64]| y.iter().map(|y| y.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&run(&printed, &u)), bits(&y));
            let changed = y.iter().zip(&plain).any(|(a, b)| (a - b).abs() > 1e-12);
            // Parameters of the controller alone are not part of the plant.
            let is_of_controller = ["k_p", "k_i", "u_max", "T_c"].iter().any(|name| {
                patched.definitions.iter().any(|d| d.name == "true_value" && d.value.mentions(name))
            });
            assert!(changed || is_of_controller, "no effect:\n{patched}");
        }
    }
}

#[test]
fn two_patches_on_an_input_act_in_order() {
    let model = example("mass_spring_damper.toml");
    let mut first = Patch::of(&model);
    first.wrap_input("force", "gained", expr("2*force")).unwrap();
    let mut second = Patch::of(&first.finish().unwrap());
    let name = second.fresh_name("gained");
    assert_eq!(name, "gained_2");
    second.wrap_input("force", &name, expr("force + 1")).unwrap();
    let both = second.finish().unwrap();
    let definitions: Vec<String> =
        both.definitions.iter().map(|d| format!("{} = {}", d.name, d.value)).collect();
    assert_eq!(definitions, ["gained = 2*gained_2", "gained_2 = force + 1"]);
    let u = signal(&model, 100);
    let by_hand: Vec<f64> = u.iter().map(|u| 2.0 * (u + 1.0)).collect();
    assert_eq!(run(&both, &u), run(&model, &by_hand));
}

#[test]
fn feedback_sees_the_wrapped_sensor_and_drives_the_wrapped_input() {
    let model = example("dc_drive_closed_loop.toml");
    let mut patch = Patch::of(&model);
    patch.wrap_output("speed", "true_speed", expr("true_speed + 10")).unwrap();
    patch.wrap_input("u", "u_motor", expr("0.8*u")).unwrap();
    let patched = patch.finish().unwrap();
    let y = run(&patched, &[100.0; 2000]);
    let last = &y[y.len() - 3..];
    // The loop brings the *measured* speed to its reference, with more voltage asked than needed.
    assert!((last[0] - 100.0).abs() < 1e-6, "{last:?}");
    let needed = 90.0 * (0.05 + 0.6 * 5e-5 / 0.05);
    assert!((0.8 * last[2] - needed).abs() < 1e-6, "{last:?}, needed {needed}");
}

#[test]
fn unknown_places_and_taken_names_are_errors() {
    let model = example("pendulum.toml");
    let mut patch = Patch::of(&model);
    let error = patch.add_force("elbow", "f", expr("1")).unwrap_err();
    assert_eq!(error.to_string(), "the model has no site `elbow`, only `joint`");
    let mut patch = Patch::of(&model);
    patch.add_definition("theta", expr("1"));
    let error = patch.finish().unwrap_err();
    assert!(matches!(error, PatchError::Model(_)), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_numbers_and_units_survive_the_file(
        which in 0..MODELS.len(),
        numbers in prop::collection::vec(any::<f64>().prop_filter("finite", |x| x.is_finite()), 20),
        unit in "[a-zµ/^%\"\\\\][^\\p{C}\\p{Zl}\\p{Zp}]{0,8}",
        // Controls and separators of lines are refused: `fd_model::is_plain`.
        description in "[^\\p{C}\\p{Zl}\\p{Zp}]*",
    ) {
        let mut draft = example(MODELS[which]).into_draft();
        for (parameter, value) in draft.parameters.iter_mut().zip(&numbers) {
            parameter.value = *value;
            parameter.tolerance = value.abs();
            parameter.bounds = Some([*value, f64::INFINITY]);
            parameter.unit.clone_from(&unit);
        }
        for (state, value) in draft.states.iter_mut().zip(&numbers) {
            state.initial = *value;
            state.tolerance = Some(value.abs());
        }
        draft.description = description;
        let model = Model::try_from(draft).unwrap();
        let again: Model = model.to_string().parse().unwrap();
        prop_assert_eq!(&again, &model);
        let bits = |model: &Model| model.parameters.iter().map(|p| p.value.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&again), bits(&model));
    }

    #[test]
    fn renaming_and_reordering_change_no_bit(
        which in 0..MODELS.len(),
        letters in prop::collection::vec("[a-z]{3,8}", 40),
    ) {
        let model = example(MODELS[which]);
        let mut draft = model.clone().into_draft();
        let names: Vec<String> = model.parameters.iter().map(|p| p.name.clone())
            .chain(model.states.iter().map(|s| s.name.clone()))
            .chain(model.definitions.iter().map(|d| d.name.clone()))
            .chain(model.inputs.iter().map(|i| i.name.clone()))
            .chain(model.tables.iter().map(|t| t.name.clone()))
            .collect();
        for (i, (from, letters)) in names.iter().zip(&letters).enumerate() {
            draft.rename(from, &format!("{letters}_{i}"));
        }
        draft.definitions.reverse();
        draft.tables.reverse();
        let renamed = Model::try_from(draft).unwrap();
        let u = signal(&model, 60);
        prop_assert_eq!(run(&renamed, &u), run(&model, &u));
    }
}
