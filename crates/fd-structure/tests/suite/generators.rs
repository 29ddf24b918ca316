//! Residual generators of equation models, run along simulations: zero while the plant is healthy, and moved by those
//! faults that the structure says.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};
use fd_structure::{
    equations::{EquationModel, FaultPlaces},
    generator::{Flow, GeneratorError, How, Residual, StepError},
};

const SAMPLES: usize = 400;
/// From here on there is a fault.
const ONSET: usize = 200;

/// Two tanks whose outflow is not solved for: in reverse, the level follows from the flow.
const TANKS: &str = r#"
version = 1
kind = "equations"
name = "tanks"
sample_time = 0.1
step = 0.05
parameters = { a = { unit = "1", value = 0.8 }, b = { unit = "1", value = 0.6 } }
inputs = { pump = { unit = "l/s", saturation = [0.0, 2.0] } }
[states]
h1 = { unit = "dm", initial = 1.0, derivative = "pump - q1" }
h2 = { unit = "dm", initial = 0.8, derivative = "q1 - q2" }
[outputs]
level1 = { unit = "dm", value = "h1" }
level2 = { unit = "dm", value = "h2" }
outflow = { unit = "l/s", value = "q2" }
[definitions]
q1 = "a*sqrt(h1)"
q2 = "b*sqrt(h2) + 0.05*h2"
"#;

/// A slow pump that never empties a tank.
fn pump(k: usize) -> f64 {
    0.7 + 0.3 * (0.05 * k as f64).sin()
}

/// Inputs and outputs of a model along a run, by name.
fn run(model: &Model, inputs: &[Vec<f64>]) -> Vec<(String, Vec<f64>)> {
    let mut simulator = EquationSimulator::<f64>::at(model, model.sample_time().unwrap()).unwrap();
    let (nu, ny) = (inputs.len(), model.outputs.len());
    let u: Vec<f64> = (0..SAMPLES).flat_map(|k| inputs.iter().map(move |input| input[k])).collect();
    let mut y = vec![0.0; ny * SAMPLES];
    simulator.simulate(&model.nominal(), &model.initial(), &u, &mut y);
    let column = |of: &[f64], n: usize, i: usize| of.iter().skip(i).step_by(n).copied().collect();
    let inputs = model.external_inputs().into_iter().enumerate();
    let inputs: Vec<_> = inputs.map(|(i, c)| (c.name, column(&u, nu, i))).collect();
    let outputs = model.outputs.iter().enumerate();
    inputs.into_iter().chain(outputs.map(|(i, o)| (o.name.clone(), column(&y, ny, i)))).collect()
}

/// The residual along a log; infinite where it cannot be computed, as in a tank that a wrong measurement has emptied.
fn residuals(residual: &Residual, log: &[(String, Vec<f64>)]) -> Vec<f64> {
    let columns: Vec<&Vec<f64>> = residual
        .knowns()
        .iter()
        .map(|name| &log.iter().find(|(known, _)| known == name).unwrap().1)
        .collect();
    let mut running = residual.start();
    (0..SAMPLES)
        .map(|k| {
            let row: Vec<f64> = columns.iter().map(|column| column[k]).collect();
            running.step(&row).unwrap_or(f64::INFINITY)
        })
        .collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}

/// Every generator that runs, with the set it is made of.
fn generators(model: &EquationModel) -> Vec<(Vec<usize>, Residual)> {
    let mut found = Vec::new();
    for set in model.structure().mso_sets(1_000).sets {
        for &equation in &set {
            match model.residual(&set, equation) {
                Ok(residual) => found.push((set.clone(), residual)),
                Err(
                    GeneratorError::NeedsDerivatives { .. } | GeneratorError::DynamicResidual(_),
                ) => {}
                Err(other) => panic!("{other}"),
            }
        }
    }
    found
}

#[test]
fn residuals_are_zero_in_health_and_move_with_the_faults_of_their_signature() {
    let model: Model = TANKS.parse().unwrap();
    let equations = EquationModel::new(&model, &"sensors".parse::<FaultPlaces>().unwrap()).unwrap();
    let structure = equations.structure();
    let generators = generators(&equations);
    // Some from formulas alone, some with an iteration, some that integrate.
    let iterates = |r: &Residual| r.solves().iter().any(|solve| solve.how == How::Newton);
    assert!(generators.iter().any(|(_, r)| iterates(r)));
    assert!(generators.iter().any(|(_, r)| r.flow() == Flow::Integral));
    assert!(generators.iter().any(|(_, r)| r.flow() == Flow::Algebraic));

    let log = run(&model, &[(0..SAMPLES).map(pump).collect()]);
    for (set, residual) in &generators {
        let healthy = largest(&residuals(residual, &log));
        // Measured signals are straight lines between samples, of which the integral is off by h^2/12 times the change of
        // the slope. Slopes of flows and levels stay within 0.2 per s: 2*0.2*0.1^2/12 = 3.3e-4.
        assert!(
            healthy < 3.3e-4,
            "{} of {:?}: {healthy}",
            residual.name(),
            structure.names_of(set)
        );
        for (fault, reacts) in structure.faults().iter().zip(structure.signature(set)) {
            let sensor = fault.name.trim_start_matches("f_");
            let mut faulty = log.clone();
            let column = faulty.iter_mut().find(|(name, _)| name == sensor).unwrap();
            column.1[ONSET..].iter_mut().for_each(|y| *y += 0.1);
            let moved = largest(&residuals(residual, &faulty)[ONSET..]);
            let says = format!("{} of {set:?}, {sensor}: {moved}", residual.name());
            assert_eq!(moved > 1e-2, reacts, "{says}");
        }
    }
}

#[test]
fn a_model_beside_the_plant_is_the_simulation_to_the_bit_or_nearly() {
    // Only inputs are known between samples, and they are held: nothing is interpolated.
    let model: Model = TANKS.parse().unwrap();
    let equations = EquationModel::new(&model, &FaultPlaces::none()).unwrap();
    let structure = equations.structure();
    let of_one_sensor = structure.mso_sets(100).sets.into_iter().find(|set| {
        let names = structure.names_of(set);
        names.contains(&"sensor level2")
            && !names.contains(&"sensor level1")
            && !names.contains(&"sensor outflow")
    });
    let set = of_one_sensor.unwrap();
    let sensor = *set.iter().find(|&&e| structure.equations()[e].name == "sensor level2").unwrap();
    let residual = equations.residual(&set, sensor).unwrap();
    assert_eq!(residual.states(), ["h1", "h2"]);
    let log = run(&model, &[(0..SAMPLES).map(pump).collect()]);
    // The same Runge-Kutta steps in another order of operations: a rounding or two per step, on values near one, which
    // the tanks forget.
    assert!(largest(&residuals(&residual, &log)) < 1e-13);
}

#[test]
fn loops_are_iterated_and_updates_stepped() {
    // A state that is updated, and two functions of it without an inverse that could be written down.
    let text = r#"
        version = 1
        kind = "equations"
        name = "loop"
        sample_time = 1.0
        inputs = { u = { unit = "1" } }
        states = { n = { unit = "1", initial = 2.0, update = "0.5*n + u" } }
        definitions = { a = "n + 0.5*sin(n)", b = "a + n + n^3" }
        outputs = { y = { unit = "1", value = "b" }, z = { unit = "1", value = "a" } }
    "#;
    let model: Model = text.parse().unwrap();
    let equations = EquationModel::new(&model, &FaultPlaces::default()).unwrap();
    let log = run(&model, &[(0..SAMPLES).map(|k| (0.3 * k as f64).sin()).collect()]);
    let generators = generators(&equations);
    assert!(generators.iter().any(|(_, r)| r.flow() == Flow::Integral));
    let mut iterated = 0;
    for (set, residual) in &generators {
        let solves = residual.solves().iter();
        iterated += solves.filter(|solve| solve.how == How::Newton).count();
        let largest = largest(&residuals(residual, &log));
        // Newton's last step is below 1e-9, its error of the order of the square.
        assert!(largest < 1e-12, "{} of {set:?}: {largest}", residual.name());
    }
    assert!(iterated > 0);
}

#[test]
fn what_cannot_be_run_is_refused_with_the_reason() {
    let model: Model = TANKS.parse().unwrap();
    let equations = EquationModel::new(&model, &FaultPlaces::default()).unwrap();
    let structure = equations.structure();
    let set = structure
        .mso_sets(100)
        .sets
        .into_iter()
        .find(|set| structure.names_of(set).contains(&"input pump"));
    let set = set.unwrap();
    let named = |name: &str| set.iter().copied().find(|&e| structure.equations()[e].name == name);
    let refusal = |equation: usize| equations.residual(&set, equation).unwrap_err().to_string();
    assert!(refusal(named("input pump").unwrap()).contains("would have to be differentiated"));
    assert!(refusal(named("d/dt h1").unwrap()).contains("drifts"));
    let outside = (0..structure.equations().len()).find(|e| !set.contains(e)).unwrap();
    assert!(refusal(outside).contains("is not one of the set"));
    let all: Vec<usize> = (0..structure.equations().len()).collect();
    let error = equations.residual(&all, 0).unwrap_err();
    assert!(error.to_string().contains("expected a minimal overdetermined set"), "{error}");
}

#[test]
fn bad_samples_are_refused_and_the_next_one_is_taken() {
    let model: Model = TANKS.parse().unwrap();
    let equations = EquationModel::new(&model, &FaultPlaces::default()).unwrap();
    let set =
        equations.structure().mso_sets(100).sets.into_iter().find(|set| set.len() == 3).unwrap();
    let is_outflow = |e: &usize| equations.structure().equations()[*e].name == "sensor outflow";
    let sensor = set.iter().copied().find(is_outflow).unwrap();
    let residual = equations.residual(&set, sensor).unwrap();
    let mut running = residual.start();
    assert_eq!(running.step(&[1.0]), Err(StepError::Signals { expected: 2, found: 1 }));
    assert_eq!(running.step(&[f64::NAN, 1.0]), Err(StepError::NotFinite));
    // An empty tank cannot be emptier.
    assert!(running.step(&[-1.0, 0.5]).is_err());
    let expected = 0.65 - (0.6 * 1.0 + 0.05);
    assert!((running.step(&[1.0, 0.65]).unwrap() - expected).abs() < 1e-12);
}
