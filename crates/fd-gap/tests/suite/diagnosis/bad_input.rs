//! Bad input: a clear finding, not a number; and no harm from simulators that fail.

use fd_effect::{EverySite, library};
use fd_gap::{
    diagnose::{Case, Diagnosis, Settings, Verdict, diagnose},
    fit::FitError,
    quality::Defect,
};
use fd_model::Record;
use fd_sim::{model::Model, scales::ReplayScales};

use crate::diagnosis::bench_cases::{Reality, example, record};

const FEW: [&str; 3] = ["coulomb-friction", "sensor-bias", "input-gain"];

fn reality(amplitude: f64) -> Reality {
    Reality { samples: 300, amplitude, parameter_error: 0.02, colour: 0.0, seed: 6 }
}

fn run(model: &Model, log: Record) -> Result<Diagnosis, FitError> {
    let u: Vec<f64> = (0..log.len()).flat_map(|k| log.u(k).to_vec()).collect();
    let scales = ReplayScales::of(model, log.ts(), &u, log.len()).unwrap();
    let effects = library().into_iter().filter(|e| FEW.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, model, scales);
    let case = Case { nominal: model, suspects: &suspects, logs: &[log], held_out: &[] };
    diagnose(&case, &Settings::default(), &())
}

fn with_inputs(log: &Record, change: impl Fn(&[f64]) -> Vec<f64>) -> Record {
    let u = (0..log.len()).flat_map(|k| change(log.u(k))).collect();
    let y = (0..log.len()).flat_map(|k| log.y(k).to_vec()).collect();
    Record::new(log.inputs().to_vec(), log.outputs().to_vec(), u, y, log.ts()).unwrap()
}

fn defects(diagnosis: &Diagnosis, channel: &str) -> Vec<Defect> {
    let of = diagnosis.findings.iter().filter(|finding| finding.channel == channel);
    of.map(|finding| finding.defect.clone()).collect()
}

#[test]
fn an_input_in_millivolts() {
    let model = example("dc_drive");
    let log = record(&model, reality(20.0), 1);
    let wrong = with_inputs(&log, |u| vec![1e3 * u[0]]);
    let found = defects(&run(&model, wrong).unwrap(), "u");
    assert_eq!(found, [Defect::WrongUnit { factor: 1e-3 }]);
    assert_eq!(defects(&run(&model, log).unwrap(), "u"), []);
}

#[test]
fn swapped_inputs() {
    let model = example("two_input");
    let log = record(&model, reality(0.0), 1);
    // Flows are not negative: the excitation about zero is put in their range.
    let steps = record(&model, Reality { amplitude: 1e-4, ..reality(0.0) }, 1);
    let u: Vec<f64> = (0..log.len())
        .flat_map(|k| [1.5e-4 + 1.3 * steps.u(k)[0], 1.2e-4 + steps.u(k)[1]])
        .collect();
    let mut y = vec![0.0; log.len() * 2];
    let mut simulator = fd_sim::simulate::EquationSimulator::<f64>::new(&model).unwrap();
    let (theta, x0) = (model.nominal(), model.initial());
    let _ = fd_sim::simulate::Simulator::simulate(&mut simulator, &theta, &x0, &u, &mut y);
    let (inputs, outputs) = (log.inputs().to_vec(), log.outputs().to_vec());
    let log = Record::new(inputs, outputs, u, y, log.ts()).unwrap();
    let swapped = with_inputs(&log, |u| vec![u[1], u[0]]);
    let found = defects(&run(&model, swapped).unwrap(), "hot");
    assert_eq!(found, [Defect::Swapped { with: "cold".into() }]);
    assert_eq!(defects(&run(&model, log).unwrap(), "hot"), []);
}

#[test]
fn an_input_that_does_not_change_and_outputs_that_nothing_excites() {
    let model = example("mass_spring_damper");
    let mut still = model.clone().into_draft();
    still.states.iter_mut().for_each(|state| state.tolerance = None);
    let still = Model::try_from(still).unwrap();
    let log = record(&still, reality(0.0), 1);
    let diagnosis = run(&model, log).unwrap();
    assert_eq!(defects(&diagnosis, "force"), [Defect::Constant]);
    assert_eq!(defects(&diagnosis, "position"), [Defect::NotExcited]);
    assert_eq!(diagnosis.verdict, Verdict::NoGap);
    assert!(!diagnosis.not_tested.is_empty());
}

/// A sensor in coarse steps, or a broken one, has not measured the plant: it neither spoils the fit nor is explained.
#[test]
fn an_output_that_stands_still_beside_another_is_left_out() {
    let model = example("dc_drive");
    let log = record(&model, reality(20.0), 1);
    let y = (0..log.len()).flat_map(|k| [log.y(k)[0], 0.0]).collect();
    let u = (0..log.len()).flat_map(|k| log.u(k).to_vec()).collect();
    let (inputs, outputs) = (log.inputs().to_vec(), log.outputs().to_vec());
    let still = Record::new(inputs, outputs, u, y, log.ts()).unwrap();
    let diagnosis = run(&model, still).unwrap();
    assert_eq!(diagnosis.verdict, Verdict::NoGap, "{:?}", diagnosis.causes[0]);
    assert_eq!(defects(&diagnosis, "speed"), [Defect::Constant]);
}

/// Hardly damped, and cut out of a longer run: how it began shows to the end of the log.
#[test]
fn a_start_that_is_never_forgotten() {
    let mut draft = example("mass_spring_damper").into_draft();
    draft.parameters[2].value = 0.05;
    let model = Model::try_from(draft.clone()).unwrap();
    (draft.states[0].initial, draft.states[1].initial) = (0.2, 0.9);
    let log = record(&Model::try_from(draft).unwrap(), reality(10.0), 1);
    let diagnosis = run(&model, log).unwrap();
    assert_eq!(diagnosis.verdict, Verdict::NoGap, "{:?}", diagnosis.causes[0]);
}

#[test]
fn a_log_that_is_shorter_than_the_memory() {
    let model = example("tanks");
    let log = record(&model, reality(0.0), 1).slice(0, 40);
    let found = defects(&run(&model, log.clone()).unwrap(), "level_1");
    assert!(found.iter().any(|defect| matches!(defect, Defect::Short { .. })), "{found:?}");
    let error = run(&model, log.slice(0, 3)).unwrap_err();
    assert!(matches!(error, FitError::TooShort { .. }), "{error}");
}

#[test]
fn a_simulator_that_fails_for_some_parameters() {
    // The root of a negative number above p = 1.02, well within the tolerance.
    let model: Model = r#"
version = 1
kind = "equations"
name = "brittle"
sample_time = 0.05
parameters = { p = { unit = "1", value = 1.0, tolerance = 0.05 } }
inputs = { u = { unit = "1" } }
outputs = { y = { unit = "1", value = "x", noise = 0.01 } }
states = { x = { unit = "1", initial = 0.0, derivative = "p*u - x*sqrt(1.02 - p)/sqrt(0.02)" } }
"#
    .parse()
    .unwrap();
    let log = record(&model, Reality { parameter_error: 0.01, ..reality(2.0) }, 1);
    let diagnosis = run(&model, log).unwrap();
    assert_eq!(diagnosis.verdict, Verdict::NoGap);
    assert!(diagnosis.refit.gap[0] < 1.2);
    assert!(diagnosis.refit.nuisances[0].value < 1.02);
}
