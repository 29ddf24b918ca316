//! Advice on the next experiment: what separates, and what nothing separates.

use std::time::Instant;

use fd_effect::{Candidate, Side, SiteRef};
use fd_gap::{
    diagnose::{Case, Diagnosis, Settings, Verdict, diagnose},
    evidence::SEPARATED,
    experiment::{Advice, Excitation, Reach, Rival, next},
};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::{
    model::{Delay, Model, Parameter},
    patch::Patch,
    simulate::{EquationSimulator, Simulator},
};

use crate::diagnosis::bench_cases::{
    Reality, Recipe, candidate, candidates, example, excitation, expr, record, sizes,
};

fn reality(amplitude: f64, seed: u64) -> Reality {
    Reality { samples: 600, amplitude, parameter_error: 0.02, colour: 0.0, seed }
}

fn run(
    model: &Model,
    suspects: &Vec<Candidate>,
    log: Record,
    reach: &Reach,
    no_gap: f64,
) -> (Diagnosis, Advice) {
    // Whatever is not beyond doubt is to be separated.
    let settings = Settings { bayes_factor: 1e6, no_gap, ..Settings::default() };
    let case = Case { nominal: model, suspects, logs: &[log], held_out: &[] };
    let diagnosis = diagnose(&case, &settings, &()).unwrap();
    for place in &diagnosis.causes {
        println!(
            "{} {:?} {:.3} {:.1}",
            place.label, place.site, place.probability, place.log_evidence
        );
    }
    println!("{:?} tied {:?} rivals {:?}", diagnosis.verdict, diagnosis.tied, diagnosis.rivals);
    let begin = Instant::now();
    let advice = next(&case, &diagnosis, reach, &()).unwrap();
    println!("{:?}: {}", begin.elapsed(), advice.statement);
    for tried in &advice.tried {
        println!("  {} {:?}", tried.experiment.name, tried.distances);
    }
    (diagnosis, advice)
}

/// A delay before or behind a plant.
fn delay(model: &Model, side: Side) -> Candidate {
    let dt = model.sample_time;
    let site = match side {
        Side::Input => SiteRef::Input(0, "force".into()),
        _ => SiteRef::Output(0, "position".into()),
    };
    let strength = [dt, 0.0, 30.0 * dt, 0.0];
    let starts = &[0.5 * dt, 2.0 * dt, 6.0 * dt];
    let recipe = Recipe { label: "delay", family: "late", site, side, strength, starts };
    candidate(model, recipe, |patch| {
        let time = expr("a");
        if side == Side::Input {
            patch.wrap_input("force", "applied", expr("late")).unwrap();
            patch.add_delay(Delay { name: "late".into(), value: expr("force"), time });
        } else {
            patch.wrap_output("position", "measured", expr("late")).unwrap();
            patch.add_delay(Delay { name: "late".into(), value: expr("measured"), time });
        }
    })
}

/// A carriage that starts at rest, so that delays before and behind it are exactly the same.
fn carriage_at_rest() -> Model {
    let text = example("mass_spring_damper").to_string();
    let mut draft = text.parse::<Model>().unwrap().into_draft();
    draft.states.iter_mut().for_each(|state| state.tolerance = None);
    Model::try_from(draft).unwrap()
}

fn late() -> (Model, Vec<Candidate>, Record) {
    let model = carriage_at_rest();
    let suspects = vec![delay(&model, Side::Input), delay(&model, Side::Output)];
    let mut patch = Patch::of(&model);
    patch.add_parameter(Parameter::new("true_late", "s", 3.0 * model.sample_time));
    patch.wrap_input("force", "seen", expr("was")).unwrap();
    let time = expr("true_late");
    patch.add_delay(Delay { name: "was".into(), value: expr("force"), time });
    let truth = patch.finish().unwrap();
    // Nothing was on its way through the delay at the start.
    let mut u = excitation(8.0, 600, 1);
    u[..20].fill(0.0);
    let mut simulator = EquationSimulator::<f64>::new(&truth).unwrap();
    let mut y = vec![0.0; u.len()];
    Simulator::simulate(&mut simulator, &truth.nominal(), &truth.initial(), &u, &mut y);
    let noise = WhiteNoise::new(0.0005, 7).values(u.len()).unwrap();
    y.iter_mut().zip(noise).for_each(|(y, e)| *y += e);
    let (inputs, outputs) = (truth.external_inputs(), truth.output_channels());
    let log = Record::new(inputs, outputs, u, y, truth.sample_time().unwrap()).unwrap();
    (model, suspects, log)
}

#[test]
fn no_input_separates_delays_before_and_behind_a_plant() {
    let (model, suspects, log) = late();
    let reach = Reach { can_measure: false, ..Reach::default() };
    let (diagnosis, advice) = run(&model, &suspects, log, &reach, 0.1);
    assert_eq!((diagnosis.verdict, diagnosis.tied.len()), (Verdict::Tied, 2));
    let tied: Vec<Rival> = diagnosis.tied.iter().copied().map(Rival::Cause).collect();
    assert_eq!(advice.between, tied);
    assert_eq!(advice.best, None);
    assert!(5 <= advice.tried.len());
    assert!(advice.tried.iter().all(|tried| tried.least() < SEPARATED));
    assert!(advice.statement.starts_with("no input within reach separates"));
}

#[test]
fn a_sensor_between_separates_them() {
    let (model, suspects, log) = late();
    let (_, advice) = run(&model, &suspects, log, &Reach::default(), 0.1);
    let best = &advice.tried[advice.best.unwrap()];
    assert_eq!(best.experiment.sensor.as_ref().unwrap().state, "v");
    assert!(SEPARATED <= best.least());
    assert!(advice.statement.contains("measure `v` as well"), "{}", advice.statement);
}

#[test]
fn a_larger_amplitude_tells_a_cubic_spring_from_a_gain() {
    let model = example("mass_spring_damper");
    let mut suspects = candidates(&model, sizes("mass_spring_damper"));
    suspects.retain(|candidate| ["cubic", "gain"].contains(&candidate.label));
    let mut patch = Patch::of(&model);
    patch.add_force("carriage", "spring", expr("-150*x^3")).unwrap();
    let truth = patch.finish().unwrap();
    // So weak that both explain it, in some of these logs.
    let found = (1..20).find_map(|seed| {
        let log = record(&truth, reality(1.3, 60 + seed), 1);
        let (diagnosis, advice) = run(&model, &suspects, log, &Reach::default(), 0.1);
        let is_cubic = diagnosis.causes[0].label == "cubic";
        (is_cubic && 1 < advice.between.len()).then_some(advice)
    });
    let advice = found.unwrap();
    let larger = advice.tried.iter().find(|t| t.experiment.excitation == Excitation::Larger);
    let logged = advice.tried.iter().find(|t| t.experiment.excitation == Excitation::Logged);
    let (larger, logged) = (larger.unwrap().least(), logged.unwrap().least());
    println!("larger {larger} logged {logged} now {}", advice.now);
    assert!(3.0 * logged < larger, "{larger} {logged}");
    let best = &advice.tried[advice.best.unwrap()];
    assert_eq!(best.experiment.excitation, Excitation::Larger);
    // A second log like the first one adds, and takes nothing away (searches stop within 1e-3).
    assert!(advice.now <= logged + 0.01);
}

#[test]
fn nothing_is_advised_where_nothing_is_left() {
    let model = example("mass_spring_damper");
    let suspects = candidates(&model, sizes("mass_spring_damper"));
    let log = record(&model, reality(10.0, 9), 1);
    let (diagnosis, advice) = run(&model, &suspects, log, &Reach::default(), 0.5);
    assert_eq!(diagnosis.verdict, Verdict::NoGap);
    assert!(advice.between.is_empty() && advice.tried.is_empty() && advice.best.is_none());
}
