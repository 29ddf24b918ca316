//! The right cause comes first, on logs of a reality that is not the library's.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests panic to fail")]

mod bench_cases;

use std::time::Instant;

use bench_cases::{Reality, candidates, example, expr, record, sizes};
use fd_gap::{
    diagnose::{Diagnosis, Settings, diagnose},
    model::{Model, Parameter},
    patch::Patch,
};

fn reality(amplitude: f64, seed: u64) -> Reality {
    Reality { samples: 1000, amplitude, parameter_error: 0.03, colour: 0.0, seed }
}

fn run(name: &str, truth: &Model, reality: Reality) -> Diagnosis {
    let model = example(name);
    let library = candidates(&model, sizes(name));
    let (log, other) = (record(truth, reality, 1), record(truth, reality, 2));
    let begin = Instant::now();
    let diagnosis = diagnose(&model, &library, &[log], &[other], &Settings::default()).unwrap();
    println!(
        "{name}: {} candidates, {} simulations, {:?}",
        library.len(),
        diagnosis.simulations,
        begin.elapsed()
    );
    println!("no gap {:.4}", diagnosis.no_gap);
    for cause in diagnosis.causes.iter().take(6) {
        println!(
            "  {:>10} {:?} p {:.4} Z {:.2} gap {:.3} {:?}",
            cause.label,
            cause.site.name(),
            cause.probability,
            cause.log_evidence,
            cause.gap,
            cause.parameters.iter().map(|p| (p.value, p.standard_error)).collect::<Vec<_>>()
        );
    }
    println!("tied {:?} rivals {:?} coloured {}", diagnosis.tied, diagnosis.rivals, diagnosis.is_coloured);
    println!("nuisances {:?}", diagnosis.nuisances);
    println!(
        "floor {:?} refit {:?} best {:?} unexplained {}",
        diagnosis.floor, diagnosis.refit_gap, diagnosis.best_gap, diagnosis.is_unexplained
    );
    println!("{:?}", diagnosis.held_out);
    println!("{:?}", diagnosis.not_tested);
    diagnosis
}

fn parameter(patch: &mut Patch, name: &str, value: f64) {
    patch.add_parameter(Parameter::new(name, "1", value));
}

#[test]
fn coulomb_friction_on_the_carriage() {
    let mut patch = Patch::of(&example("mass_spring_damper"));
    parameter(&mut patch, "true_f", 0.4);
    // Not the library's tanh: a steep algebraic sigmoid.
    let law = expr("-true_f*v/sqrt(v^2 + 0.004^2)");
    patch.add_force("carriage", "friction", law).unwrap();
    let diagnosis = run("mass_spring_damper", &patch.finish().unwrap(), reality(10.0, 3));
    let first = &diagnosis.causes[0];
    assert_eq!((first.label, diagnosis.tied.len()), ("coulomb", 1));
    assert!(0.9 < first.probability);
    let strength = &first.parameters[0];
    // Three standard errors, and what the other shape of the law makes of it (a few percent).
    assert!((strength.value - 0.4).abs() < 3.0 * strength.standard_error + 0.04 * 0.4);
}

#[test]
fn dead_zone_of_the_drive() {
    let mut patch = Patch::of(&example("dc_drive"));
    parameter(&mut patch, "true_w", 0.6);
    patch.wrap_input("u", "seen", expr("u - clamp(u, -true_w, true_w)")).unwrap();
    let diagnosis = run("dc_drive", &patch.finish().unwrap(), reality(20.0, 5));
    assert_eq!(diagnosis.causes[0].label, "dead-zone");
    assert!(0.9 < diagnosis.causes[0].probability);
}

#[test]
fn bias_of_the_sensor() {
    let mut patch = Patch::of(&example("dc_drive"));
    parameter(&mut patch, "true_b", 0.3);
    patch.wrap_output("current", "seen", expr("seen + true_b")).unwrap();
    let diagnosis = run("dc_drive", &patch.finish().unwrap(), reality(20.0, 7));
    let first = &diagnosis.causes[0];
    assert_eq!((first.label, first.site.name()), ("bias", Some("current")));
    assert!(0.9 < first.probability);
}

#[test]
fn no_gap_stays_no_gap() {
    for seed in 0..6 {
        let name = if seed % 2 == 0 { "mass_spring_damper" } else { "dc_drive" };
        let amplitude = if seed % 2 == 0 { 10.0 } else { 20.0 };
        let colour = if seed < 4 { 0.0 } else { 0.8 };
        let reality = Reality { colour, ..reality(amplitude, 100 + seed) };
        let diagnosis = run(name, &example(name), reality);
        assert!(0.5 < diagnosis.no_gap, "seed {seed}: {}", diagnosis.no_gap);
    }
}
