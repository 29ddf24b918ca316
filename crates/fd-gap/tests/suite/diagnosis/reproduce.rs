//! The patched model, printed, parsed and run, reproduces what the diagnosis reports to the bit.

use fd_effect::{EverySite, library};
use fd_gap::{
    diagnose::{Case, Diagnosis, Explanation, Settings, Verdict, diagnose},
    fit::Horizon,
};
use fd_model::Record;
use fd_sim::{
    model::Model,
    patch::Patch,
    scales::ReplayScales,
    simulate::{EquationSimulator, Simulator},
};

use crate::diagnosis::bench_cases::{Reality, example, expr, record};

/// The library without what these cases do not need.
fn diagnosis(model: &Model, logs: &[Record], horizon: Horizon, only: &[&str]) -> Diagnosis {
    let first = &logs[0];
    let u: Vec<f64> = (0..first.len()).flat_map(|k| first.u(k).to_vec()).collect();
    let scales = ReplayScales::of(model, first.ts(), &u, first.len()).unwrap();
    let effects = library().into_iter().filter(|e| only.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, model, scales);
    let settings = Settings { horizon, ..Settings::default() };
    let case = Case { nominal: model, suspects: &suspects, logs, held_out: &[] };
    diagnose(&case, &settings, &()).unwrap()
}

/// Runs the model as it is printed, from the starts of the explanation.
fn rerun(explanation: &Explanation, logs: &[Record]) -> Vec<Vec<f64>> {
    let model: Model = explanation.model.to_string().parse().unwrap();
    let ny = model.outputs.len();
    let mut outputs: Vec<Vec<f64>> = logs.iter().map(|l| vec![f64::NAN; l.len() * ny]).collect();
    for (i, start) in explanation.starts.iter().enumerate() {
        let log = &logs[start.log];
        let next = explanation.starts.get(i + 1).filter(|next| next.log == start.log);
        let end = next.map_or(log.len(), |next| next.from);
        let mut simulator = EquationSimulator::<f64>::at(&model, log.ts()).unwrap();
        simulator.start(&model.nominal(), &start.state, start.from as u64);
        for k in start.from..end {
            let row = &mut outputs[start.log][k * ny..(k + 1) * ny];
            simulator.step(log.u(k), log.u((k + 1).min(log.len() - 1)), &[], row);
        }
    }
    outputs
}

fn check(diagnosis: &Diagnosis, logs: &[Record]) {
    for explanation in [&diagnosis.nominal, &diagnosis.refit, &diagnosis.best] {
        let outputs = rerun(explanation, logs);
        for (a, b) in outputs.iter().flatten().zip(explanation.outputs.iter().flatten()) {
            assert_eq!(a.to_bits(), b.to_bits(), "{a} {b}");
        }
        // The gap, from the outputs.
        let ny = diagnosis.sigma.len();
        for (c, sigma) in diagnosis.sigma.iter().enumerate() {
            let (mut sum, mut count) = (0.0, 0.0);
            for (log, outputs) in logs.iter().zip(&outputs) {
                for k in 0..log.len() {
                    let error = (outputs[k * ny + c] - log.y(k)[c]) / sigma;
                    sum += error * error;
                    count += 1.0;
                }
            }
            assert_eq!(f64::sqrt(sum / count).to_bits(), explanation.gap[c].to_bits());
        }
    }
}

fn reality(amplitude: f64, seed: u64) -> Reality {
    Reality { samples: 400, amplitude, parameter_error: 0.03, colour: 0.0, seed }
}

const FEW: [&str; 4] = ["coulomb-friction", "input-delay", "sensor-bias", "input-lag"];

#[test]
fn of_single_effects_in_free_run_and_windows() {
    for (name, site, law, amplitude) in [
        ("mass_spring_damper", "carriage", "-0.4*v/sqrt(v^2 + 0.004^2)", 10.0),
        ("dc_drive", "shaft", "-0.02*omega/sqrt(omega^2 + 1.5)", 20.0),
        ("dc_drive_closed_loop", "shaft", "-0.02*omega/sqrt(omega^2 + 1.5)", 200.0),
        ("cart_pole", "rail", "-0.5*v/sqrt(v^2 + 1e-4)", 8.0),
    ] {
        let model = example(name);
        let mut patch = Patch::of(&model);
        patch.add_force(site, "friction", expr(law)).unwrap();
        let truth = patch.finish().unwrap();
        let logs = [1, 2].map(|seed| record(&truth, reality(amplitude, 5), seed));
        for horizon in [Horizon::FreeRun, Horizon::Windows { samples: 80 }] {
            let diagnosis = diagnosis(&model, &logs, horizon, &FEW);
            assert_eq!(diagnosis.causes[0].label, "coulomb-friction", "{name} {horizon:?}");
            check(&diagnosis, &logs);
        }
    }
}

#[test]
fn of_effects_with_memory_and_of_no_effect() {
    let model = example("dc_drive");
    for (seed, time, label) in [(7, 0.005, "input-delay"), (8, 0.0, "")] {
        let mut patch = Patch::of(&model);
        patch.wrap_input("u", "seen", expr("late")).unwrap();
        let (value, time) = (expr("u"), fd_sim::equation::Expr::Number(time));
        patch.add_delay(fd_sim::model::Delay { name: "late".into(), value, time });
        let truth = if label.is_empty() { model.clone() } else { patch.finish().unwrap() };
        let logs = [record(&truth, reality(20.0, seed), 1)];
        let diagnosis = diagnosis(&model, &logs, Horizon::FreeRun, &FEW);
        assert_eq!(diagnosis.verdict == Verdict::NoGap, label.is_empty());
        assert!(label.is_empty() || diagnosis.causes[0].label == label);
        check(&diagnosis, &logs);
    }
}

#[test]
fn of_a_pair() {
    let model = example("mass_spring_damper");
    let mut patch = Patch::of(&model);
    patch.add_force("carriage", "friction", expr("-0.5*v/sqrt(v^2 + 0.004^2)")).unwrap();
    patch.wrap_input("force", "seen", expr("late")).unwrap();
    let (value, time) = (expr("force"), fd_sim::equation::Expr::Number(0.03));
    patch.add_delay(fd_sim::model::Delay { name: "late".into(), value, time });
    let logs = [record(&patch.finish().unwrap(), reality(10.0, 9), 1)];
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| diagnosis(&model, &logs, Horizon::FreeRun, &FEW))
    };
    let diagnosis = on(1);
    // Not `==`: NaN would differ from itself.
    assert_eq!(format!("{diagnosis:?}"), format!("{:?}", on(3)));
    assert_eq!(diagnosis.verdict, Verdict::Pair);
    let pair = &diagnosis.pairs[0];
    let mut labels = pair.causes.each_ref().map(|cause| cause.label);
    labels.sort_unstable();
    assert_eq!(labels, ["coulomb-friction", "input-delay"]);
    check(&diagnosis, &logs);
    let delay = pair.causes.iter().find(|cause| cause.label == "input-delay").unwrap();
    let estimate = &delay.parameters[0];
    assert!((estimate.value - 0.03).abs() < 4.0 * estimate.standard_error + 1e-4);
}
