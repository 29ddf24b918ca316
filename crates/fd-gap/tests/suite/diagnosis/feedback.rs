//! A controller in the loop sees the noise of the sensors, and the diagnosis knows it.
use fd_effect::{EverySite, library};
use fd_gap::{
    diagnose::{Case, Diagnosis, Settings, diagnose},
    quality::{Defect, Finding},
};
use fd_model::{
    Record,
    signal::{ArNoise, WhiteNoise},
};
use fd_sim::{
    model::{Hold, Input, Model},
    patch::Patch,
    scales::ReplayScales,
    simulate::{EquationSimulator, LoggedLoop, Nominal, Simulator},
};

use crate::diagnosis::bench_cases::{example, excitation, expr};

const SAMPLES: usize = 600;

/// The drive under its speed controller, logged with a noise that the controller sees if
/// `is_in_loop`.
fn record(truth: &Model, colour: f64, is_in_loop: bool, seed: u64) -> Record {
    record_with(truth, colour, is_in_loop, seed, 1.0)
}

/// The same with so much of the noise in the command, which is logged as the third output.
fn record_with(truth: &Model, colour: f64, is_in_loop: bool, seed: u64, of_command: f64) -> Record {
    let nominal = example("dc_drive_closed_loop");
    let ny = nominal.outputs.len();
    let noise: Vec<Vec<f64>> = (0..ny)
        .map(|c| {
            let (sigma, seed) = (nominal.outputs[c].noise.unwrap(), seed + c as u64);
            let noise = if colour == 0.0 {
                WhiteNoise::new(sigma, seed).values(SAMPLES)
            } else {
                ArNoise::new(vec![colour], sigma, seed).values(SAMPLES)
            };
            let part = if c == 2 { of_command } else { 1.0 };
            noise.unwrap().into_iter().map(|e| part * e).collect()
        })
        .collect();
    let model = if is_in_loop { with_noise(truth) } else { truth.clone() };
    let reference = excitation(120.0, SAMPLES, seed + 100);
    let inputs = model.external_inputs().len();
    let u: Vec<f64> = (0..SAMPLES)
        .flat_map(|k| {
            // The inputs of the noise come before the reference of the controller.
            let noise = noise.iter().take(inputs - 1).map(|noise| noise[k]);
            noise.chain([reference[k]]).collect::<Vec<_>>()
        })
        .collect();
    let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
    let ts = simulator.ts();
    let mut y = vec![0.0; SAMPLES * ny];
    let outcome =
        Simulator::simulate(&mut simulator, &model.nominal(), &model.initial(), &u, &mut y);
    assert_eq!(outcome, fd_sim::simulate::Outcome::Complete);
    if !is_in_loop {
        for (c, noise) in noise.iter().enumerate() {
            y.iter_mut().skip(c).step_by(ny).zip(noise).for_each(|(y, e)| *y += e);
        }
    }
    Record::new(nominal.external_inputs(), nominal.output_channels(), reference, y, ts).unwrap()
}

/// Sensors with noise from outside, which the controller sees.
fn with_noise(model: &Model) -> Model {
    assert_eq!(model.hold, Hold::Zero);
    let mut patch = Patch::of(model);
    for output in &model.outputs {
        let (noise, clean) = (format!("{}_noise", output.name), format!("{}_clean", output.name));
        let unit = output.unit.clone();
        patch.add_input(Input { name: noise.clone(), unit, saturation: None });
        patch.wrap_output(&output.name, &clean, expr(&format!("{clean} + {noise}"))).unwrap();
    }
    patch.finish().unwrap()
}

fn diagnosis(logs: &[Record]) -> Diagnosis {
    let model = example("dc_drive_closed_loop");
    let u: Vec<f64> = (0..SAMPLES).flat_map(|k| logs[0].u(k).to_vec()).collect();
    let scales = ReplayScales::of(&model, logs[0].ts(), &u, SAMPLES).unwrap();
    let few = ["coulomb-friction", "input-gain", "input-delay", "periodic-force", "sensor-bias"];
    let effects = library().into_iter().filter(|e| few.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, &model, scales);
    let case = Case { nominal: &model, suspects: &suspects, logs, held_out: &[] };
    diagnose(&case, &Settings::default(), &()).unwrap()
}

#[test]
fn the_plant_sees_the_commands_of_the_log() {
    let model = example("dc_drive_closed_loop");
    let log = record(&model, 0.0, true, 1);
    let logged = LoggedLoop::of(&model, log.ts()).unwrap();
    let mut simulator = logged.simulator(log.ts()).unwrap();
    let names: Vec<&str> = simulator.inputs().iter().map(|i| i.name.as_str()).collect();
    assert_eq!(names, ["speed_ref", "speed_logged"]);
    let with_outputs = logged.record(&log).unwrap();
    let u: Vec<f64> = (0..SAMPLES).flat_map(|k| with_outputs.u(k).to_vec()).collect();
    let mut y = vec![0.0; SAMPLES * 3];
    let _ = simulator.simulate(&model.nominal(), &model.initial(), &u, &mut y);
    for (c, sigma) in [0.2, 0.02, 0.001].into_iter().enumerate() {
        let errors = (0..SAMPLES).map(|k| (log.y(k)[c] - y[3 * k + c]) / sigma);
        let squares: f64 = errors.map(|e| e * e).sum();
        // What is left is the noise itself: 600 independent samples, five standard deviations.
        assert!((squares / 600.0 - 1.0).abs() < 5.0 * f64::sqrt(2.0 / 600.0), "{c} {squares}");
    }
    // The loop that is closed in the simulation does not know of the noise.
    let mut closed = model.simulator(log.ts()).unwrap();
    let u: Vec<f64> = (0..SAMPLES).flat_map(|k| log.u(k).to_vec()).collect();
    let _ = closed.simulate(&model.nominal(), &model.initial(), &u, &mut y);
    let voltage: f64 = (0..SAMPLES).map(|k| (log.y(k)[2] - y[3 * k + 2]).powi(2)).sum();
    assert!(4.0 < (voltage / 600.0).sqrt() / 0.001, "{voltage}");
}

#[test]
fn missing_outputs_are_interpolated() {
    let model = example("dc_drive_closed_loop");
    let mut log = record(&model, 0.0, true, 1).slice(0, 6);
    for (k, value) in [f64::NAN, 2.0, f64::NAN, f64::NAN, 8.0, f64::NAN].into_iter().enumerate() {
        log.y_mut(k)[0] = value;
    }
    let logged = LoggedLoop::of(&model, log.ts()).unwrap();
    let filled: Vec<f64> = logged.record(&log).unwrap().input(1).collect();
    assert_eq!(filled, [2.0, 2.0, 4.0, 6.0, 8.0, 8.0]);
}

#[test]
fn noise_that_goes_round_the_loop_is_no_effect() {
    let truth = example("dc_drive_closed_loop");
    for (colour, seed) in [(0.0, 11), (0.8, 21), (0.8, 31)] {
        let found = diagnosis(&[record(&truth, colour, true, seed)]);
        assert!(found.is_logged_loop, "{seed}");
        assert!(0.5 < found.no_gap, "{seed} {}", found.no_gap);
    }
}

/// A command that is logged as it was given is exactly what the controller makes of the log: no noise is less than that.
#[test]
fn an_exact_command_is_no_reason_to_close_the_loop() {
    let truth = example("dc_drive_closed_loop");
    for seed in [51, 61] {
        let found = diagnosis(&[record_with(&truth, 0.0, true, seed, 0.0)]);
        assert!(found.is_logged_loop, "{seed}");
        assert!(0.5 < found.no_gap, "{seed} {}", found.no_gap);
        let of_controller = |finding: &&Finding| finding.defect == Defect::Commanded;
        let told: Vec<&str> =
            found.findings.iter().filter(of_controller).map(|f| f.channel.as_str()).collect();
        assert_eq!(told, [truth.outputs[2].name.as_str()], "{seed}");
        assert!(found.best.gap.iter().all(|gap| gap.is_finite()), "{:?}", found.best.gap);
    }
}

/// Rounding of a file that goes through an integrator is a drift of the command, and no effect.
#[test]
fn a_command_of_rounded_outputs_has_no_effect_of_its_own() {
    let log = record_with(&example("dc_drive_closed_loop"), 0.0, true, 71, 0.0);
    let digits = |value: f64| -> f64 { format!("{value:.4e}").parse().unwrap() };
    let rows = (0..log.len()).map(|k| {
        let row = |values: &[f64]| values.iter().copied().map(digits).collect::<Vec<_>>();
        (row(log.u(k)), row(log.y(k)))
    });
    let (inputs, outputs) = (log.inputs().to_vec(), log.outputs().to_vec());
    let rounded = Record::from_rows(inputs, outputs, rows, log.ts()).unwrap();
    let found = diagnosis(&[rounded]);
    assert!(found.is_logged_loop);
    assert!(0.5 < found.no_gap, "{}", found.no_gap);
}

#[test]
fn a_controller_that_saw_no_noise_is_left_alone() {
    let found = diagnosis(&[record(&example("dc_drive_closed_loop"), 0.0, false, 41)]);
    assert!(!found.is_logged_loop);
    assert!(0.5 < found.no_gap, "{}", found.no_gap);
}

#[test]
fn friction_in_a_noisy_loop_is_found() {
    let mut patch = Patch::of(&example("dc_drive_closed_loop"));
    patch.add_force("shaft", "friction", expr("-0.01*omega/sqrt(omega^2 + 1)")).unwrap();
    let found = diagnosis(&[record(&patch.finish().unwrap(), 0.8, true, 51)]);
    assert!(found.is_logged_loop);
    assert_eq!(found.causes[0].label, "coulomb-friction");
    assert_eq!(found.causes[0].site.name(), Some("shaft"));
    // The patched simulator is the one with its loop closed.
    assert_eq!(found.best.model.external_inputs().len(), 1);
}
