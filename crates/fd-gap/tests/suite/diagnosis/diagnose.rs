//! The right cause comes first, on logs of a reality that is not the library's.

use std::time::Instant;

use fd_effect::Candidate;
use fd_gap::diagnose::{Case, Diagnosis, Settings, diagnose};
use fd_model::Record;
use fd_sim::{
    model::{Model, Parameter},
    patch::Patch,
};

use crate::diagnosis::bench_cases::{Reality, candidates, example, expr, record, sizes};

/// A diagnosis with candidates that are there already.
fn with(
    model: &Model,
    library: &[Candidate],
    logs: &[Record],
    held_out: &[Record],
    settings: &Settings,
) -> Diagnosis {
    let suspects = library.to_vec();
    let case = Case { nominal: model, suspects: &suspects, logs, held_out };
    diagnose(&case, settings, &()).unwrap()
}

fn reality(amplitude: f64, seed: u64) -> Reality {
    Reality { samples: 1000, amplitude, parameter_error: 0.03, colour: 0.0, seed }
}

fn run(name: &str, truth: &Model, reality: Reality) -> Diagnosis {
    let model = example(name);
    let library = candidates(&model, sizes(name));
    let (log, other) = (record(truth, reality, 1), record(truth, reality, 2));
    let begin = Instant::now();
    let diagnosis = with(&model, &library, &[log], &[other], &Settings::default());
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
    println!(
        "tied {:?} rivals {:?} coloured {}",
        diagnosis.tied, diagnosis.rivals, diagnosis.is_coloured
    );
    println!("nuisances {:?}", diagnosis.best.nuisances);
    println!(
        "floor {:?} refit {:?} best {:?} unexplained {}",
        diagnosis.floor, diagnosis.refit.gap, diagnosis.best.gap, diagnosis.is_unexplained
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

fn friction() -> Model {
    let mut patch = Patch::of(&example("dc_drive"));
    parameter(&mut patch, "true_f", 0.02);
    let law = expr("-true_f*omega/sqrt(omega^2 + 1.5)");
    patch.add_force("shaft", "friction", law).unwrap();
    patch.finish().unwrap()
}

/// Probabilities by label and site, and that of no gap.
fn summary(diagnosis: &Diagnosis) -> Vec<(String, f64)> {
    let cause = |c: &fd_gap::diagnose::Cause| (format!("{} {:?}", c.label, c.site), c.log_evidence);
    let mut all: Vec<_> = diagnosis.causes.iter().map(cause).collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all.push((String::new(), diagnosis.no_gap));
    all
}

#[test]
fn names_order_and_units_of_channels_do_not_matter() {
    let model = example("dc_drive");
    let log = record(&friction(), reality(20.0, 21), 1).slice(0, 400);
    let settings = Settings::default();
    let library = candidates(&model, sizes("dc_drive"));
    let plain = with(&model, &library, std::slice::from_ref(&log), &[], &settings);
    assert_eq!(plain.causes[0].label, "coulomb");

    // Other units, another order, and a channel that the model does not know.
    let other = log.in_units(&["mV"], &["mA", "rpm"]).unwrap();
    let (u, y) = (other.u(0).len(), other.y(0).len());
    assert_eq!((u, y), (1, 2));
    let names = [&other.outputs()[1], &other.outputs()[0], &fd_model::Channel::new("T", "degC")];
    let rows =
        (0..other.len()).map(|k| (vec![other.u(k)[0]], vec![other.y(k)[1], other.y(k)[0], 20.0]));
    let outputs = names.map(Clone::clone).to_vec();
    let shuffled =
        fd_model::Record::from_rows(other.inputs().to_vec(), outputs, rows, other.ts()).unwrap();
    let same = with(&model, &library, &[shuffled], &[], &settings);
    for ((name, a), (other, b)) in summary(&plain).iter().zip(&summary(&same)) {
        // Conversions round to 1e-16; searches stop within 1e-3 of the least cost.
        assert!(name == other && (a - b).abs() < 0.05, "{name}: {a} {other}: {b}");
    }

    // Other names.
    let rename = |text: &str| text.replace("current", "amperes").replace("speed", "rate");
    let renamed: Model = rename(&model.to_string()).parse().unwrap();
    let size = |what: &str| match what {
        "amperes" => sizes("dc_drive")("current"),
        "rate" => sizes("dc_drive")("speed"),
        other => sizes("dc_drive")(other),
    };
    let library = candidates(&renamed, size);
    let channels = renamed.output_channels();
    let rows = log.samples().map(|(u, y)| (u.to_vec(), y.to_vec()));
    let log = fd_model::Record::from_rows(log.inputs().to_vec(), channels, rows, log.ts()).unwrap();
    let same = with(&renamed, &library, &[log], &[], &settings);
    let bits =
        |d: &Diagnosis| d.causes.iter().map(|c| c.log_evidence.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&plain), bits(&same));
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let model = example("dc_drive");
    let log = record(&friction(), reality(20.0, 22), 1).slice(0, 300);
    let library = candidates(&model, sizes("dc_drive"));
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let logs = [log.clone()];
        pool.install(|| with(&model, &library, &logs, &logs, &Settings::default()))
    };
    // Not `==`: NaN would differ from itself.
    assert_eq!(format!("{:?}", on(1)), format!("{:?}", on(3)));
}

#[test]
fn another_candidate_never_raises_the_best_fit_error() {
    let model = example("dc_drive");
    let log = record(&friction(), reality(20.0, 23), 1).slice(0, 400);
    let library = candidates(&model, sizes("dc_drive"));
    let settings = Settings { finalists: 4, ..Settings::default() };
    let mut least = f64::INFINITY;
    for n in [1, 4, 8, 12, library.len()] {
        let diagnosis = with(&model, &library[..n], std::slice::from_ref(&log), &[], &settings);
        let best = diagnosis.causes.iter().map(|cause| cause.gap).fold(f64::INFINITY, f64::min);
        // Both ended within 1e-3 of their least cost, of 800.
        assert!(best <= least + 1e-6, "{n}: {best} after {least}");
        least = best;
    }
}

#[test]
fn candidates_that_diverge_do_no_harm() {
    let model = example("mass_spring_damper");
    let mut patch = Patch::of(&model);
    parameter(&mut patch, "true_k", 900.0);
    patch.add_force("carriage", "spring", expr("-true_k*x^3")).unwrap();
    let log = record(&patch.finish().unwrap(), reality(15.0, 31), 1);
    let mut library = candidates(&model, sizes("mass_spring_damper"));
    let cubic = library.iter().position(|candidate| candidate.label == "cubic").unwrap();
    // A spring that repels explodes; the first start does so at once.
    library[cubic].starts.insert(0, vec![-1e9]);
    library[cubic].parameters[0].low = -1e12;
    let mut bomb = library[cubic].clone();
    bomb.label = "bomb";
    bomb.starts = vec![vec![-1e9], vec![-1e11]];
    bomb.parameters[0].high = -1e8;
    library.push(bomb);
    let diagnosis = with(&model, &library, &[log], &[], &Settings::default());
    assert_eq!(diagnosis.causes[0].label, "cubic");
    let strength = &diagnosis.causes[0].parameters[0];
    assert!((strength.value - 900.0).abs() < 4.0 * strength.standard_error);
    let failed: Vec<(&str, &str)> =
        diagnosis.not_tested.iter().map(|n| (n.label, n.reason.as_str())).collect();
    // Each of the others could explain next to nothing of what the spring does.
    let (bombs, others): (Vec<_>, Vec<_>) =
        failed.into_iter().partition(|(label, _)| *label == "bomb");
    assert_eq!(bombs, [("bomb", "its simulation diverges")]);
    assert!(others.iter().all(|(_, reason)| *reason == "others promise far more"), "{others:?}");
}

#[test]
fn gain_and_scale_of_a_linear_plant_are_one_answer() {
    let model = example("mass_spring_damper");
    let mut patch = Patch::of(&model);
    parameter(&mut patch, "true_g", 0.3);
    patch.wrap_input("force", "seen", expr("(1 + true_g)*force")).unwrap();
    let diagnosis = run("mass_spring_damper", &patch.finish().unwrap(), reality(8.0, 41));
    let tied: Vec<&str> = diagnosis.tied.iter().map(|id| diagnosis.causes[id.0].label).collect();
    assert!(tied.contains(&"gain") && tied.contains(&"scale"), "{tied:?}");
    assert!(!tied.contains(&"coulomb") && !tied.contains(&"dead-zone"), "{tied:?}");
}

#[test]
fn windows_and_several_logs_name_the_cause_too() {
    use fd_gap::fit::Horizon::{FreeRun, Windows};

    let model = example("dc_drive");
    let library = candidates(&model, sizes("dc_drive"));
    let truth = friction();
    let logs = [1, 2].map(|seed| record(&truth, reality(20.0, 51), seed).slice(0, 500));
    let held_out = [record(&truth, reality(20.0, 51), 3)];
    let horizon = Windows { samples: 100 };
    let settings =
        Settings { horizon, report_horizons: vec![horizon, FreeRun], ..Settings::default() };
    let diagnosis = with(&model, &library, &logs, &held_out, &settings);
    assert_eq!(diagnosis.causes[0].label, "coulomb");
    assert_eq!(diagnosis.held_out.len(), 2);
    for held_out in &diagnosis.held_out {
        let closed = held_out.closed_of_refit.unwrap();
        println!("{held_out:?}");
        assert!(0.9 < closed.interval[0] && closed.interval[0] <= closed.fraction);
    }
}

/// With the whole library; prints the time.
#[test]
fn the_library_names_coulomb_friction() {
    use fd_effect::{library, offers};
    use fd_sim::scales::ReplayScales;

    for (name, site, law, amplitude) in [
        ("mass_spring_damper", "carriage", "-0.4*v/sqrt(v^2 + 0.004^2)", 10.0),
        ("dc_drive", "shaft", "-0.02*omega/sqrt(omega^2 + 1.5)", 20.0),
    ] {
        let model = example(name);
        let mut patch = Patch::of(&model);
        patch.add_force(site, "friction", expr(law)).unwrap();
        let truth = patch.finish().unwrap();
        let logs = [record(&truth, reality(amplitude, 61), 1)];
        let u: Vec<f64> = (0..logs[0].len()).flat_map(|k| logs[0].u(k).to_vec()).collect();
        let scales = ReplayScales::of(&model, logs[0].ts(), &u, logs[0].len()).unwrap();
        let all: Vec<_> =
            offers(&library(), &model, &scales).into_iter().filter_map(Result::ok).collect();
        let begin = Instant::now();
        let diagnosis = with(&model, &all, &logs, &[], &Settings::default());
        println!(
            "{name}: {} candidates, {} causes, {} simulations, {:?}; no gap {:.3}",
            all.len(),
            diagnosis.causes.len(),
            diagnosis.simulations,
            begin.elapsed(),
            diagnosis.no_gap
        );
        for cause in diagnosis.causes.iter().take(6) {
            println!(
                "  {} ({}) {:?} p {:.4} Z {:.2} gap {:.3} {:?}",
                cause.label,
                cause.law,
                cause.site,
                cause.probability,
                cause.log_evidence,
                cause.gap,
                cause.parameters.iter().map(|p| (&p.name, p.value)).collect::<Vec<_>>()
            );
        }
        println!("  tied {:?} rivals {:?}", diagnosis.tied, diagnosis.rivals);
        println!("  {:?}", diagnosis.not_tested);
        assert_eq!(diagnosis.causes[0].family, "friction");
    }
}
