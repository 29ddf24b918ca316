//! Laws of sets of effects, on a lag with a dead zone and an end that its model does not know.

use fd_effect::{Candidate, EverySite, library};
use fd_gap::diagnose::{Case, EffectSet, SetSearch, Settings, Wanted, diagnose};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::{model::Model, scales::ReplayScales};

/// A lag with a well known time constant.
const MODEL: &str = r#"
version = 1
kind = "equations"
name = "lag"
sample_time = 0.1
parameters = { T = { unit = "s", value = 0.5, tolerance = 0.02 } }
inputs = { u = { unit = "V" } }
states = { x = { unit = "V", initial = 0.0, derivative = "(u - x)/T" } }
outputs = { y = { unit = "V", value = "x", noise = 0.02 } }
"#;

const SAMPLES: usize = 400;

/// A dead zone and an end that the model does not know, and noise.
fn reality(model: &Model) -> Record {
    let noise = WhiteNoise::new(0.02, 4).values(SAMPLES).unwrap();
    let mut x = 0.0_f64;
    let rows = (0..SAMPLES).map(|k| {
        let t = k as f64;
        let u = 1.3 * (0.031 * t).sin() + 0.7 * (0.13 * t).sin() + 0.3 * (0.41 * t).cos();
        let y = x + noise[k];
        let acts = (u - u.clamp(-0.2, 0.2)).clamp(-1.2, 1.2);
        x = acts + (x - acts) * (-0.2_f64).exp();
        ([u], [y])
    });
    let rows: Vec<([f64; 1], [f64; 1])> = rows.collect();
    let (inputs, outputs) = (model.external_inputs(), model.output_channels());
    Record::from_rows(inputs, outputs, rows, model.sample_time().unwrap()).unwrap()
}

const ZONE: [&str; 2] = ["input-dead-zone", "symmetric"];
const END: [&str; 2] = ["input-saturation", "hard"];

/// Asks a search for sets with a few effects.
fn with_search(ask: impl FnOnce(&SetSearch<'_>)) {
    let model: Model = MODEL.parse().unwrap();
    let logs = [reality(&model)];
    let u: Vec<f64> = (0..SAMPLES).flat_map(|k| logs[0].u(k).to_vec()).collect();
    let scales = ReplayScales::of(&model, logs[0].ts(), &u, SAMPLES).unwrap();
    let few = ["input-dead-zone", "input-saturation", "input-gain", "sensor-bias", "input-lag"];
    let effects = library().into_iter().filter(|e| few.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, &model, scales);
    let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &[] };
    let settings = Settings::default();
    let first = diagnose(&case, &settings, &()).unwrap();
    ask(&SetSearch::new(&case, &first, None, false, &settings, &()).unwrap());
}

/// The set with an effect of this label and law more.
fn beside(search: &SetSearch<'_>, set: &EffectSet, [label, law]: [&str; 2]) -> EffectSet {
    let is_it = |candidate: &Candidate| candidate.label == label && candidate.law == law;
    let found = search.beside(set, &Wanted { candidate: &is_it, least: 0.0 }).unwrap();
    found.into_iter().next().unwrap()
}

/// What is added can be absent, so that no set leaves more than what it was added to.
#[test]
fn no_effect_more_makes_a_fit_worse() {
    with_search(|search| {
        let all = Wanted { candidate: &|_| true, least: 0.0 };
        let none = search.none().unwrap();
        let mut before = none;
        for _ in 0..2 {
            let more = search.beside(&before, &all).unwrap();
            for set in &more {
                // To a hundredth of a nat, to which fits go.
                assert!(set.cost() <= before.cost() + 0.02, "{} {}", set.cost(), before.cost());
            }
            before = more.into_iter().next().unwrap();
        }
    });
}

/// Which of two came first is no part of the answer, and neither is taking one out and putting it back.
#[test]
fn the_order_of_a_set_changes_no_evidence() {
    with_search(|search| {
        let none = search.none().unwrap();
        let one = beside(search, &beside(search, &none, ZONE), END);
        let other = beside(search, &beside(search, &none, END), ZONE);
        let turned = search.only(&one, &[1, 0]).unwrap();
        let back = beside(search, &search.only(&one, &[0]).unwrap(), END);
        for (set, same) in [(&other, &turned), (&back, &one)] {
            // To a hundredth of a nat, to which fits go.
            assert!(set.is_same(&one) && (set.cost() - one.cost()).abs() < 0.04, "{}", set.cost());
            assert!((set.log_evidence - same.log_evidence).abs() < 0.02, "{}", set.log_evidence);
        }
        // What is an end of 1.4 V before the dead zone of 0.2 V is one of 1.2 V behind it, and the prior of a strength goes
        // by its logarithm.
        let less = one.log_evidence - other.log_evidence;
        assert!((less.abs() - (7.0_f64 / 6.0).ln()).abs() < 0.02, "{less}");
        assert_eq!(turned.members[0].label, END[0]);
    });
}

/// What is there is worth its place, what is not gains nothing, and only all of it is noise.
#[test]
fn the_right_set_is_noise_and_less_is_not() {
    with_search(|search| {
        let none = search.none().unwrap();
        let zone = beside(search, &none, ZONE);
        let both = beside(search, &zone, END);
        assert!(search.is_noise(&both) && !search.is_noise(&zone) && !search.is_noise(&none));
        assert!(5.0 < search.gain(&both, &zone));
        // Something that is not there gains nothing.
        let more = beside(search, &both, ["sensor-bias", "constant"]);
        assert!(search.gain(&more, &both) < 0.0, "{}", search.gain(&more, &both));
        assert!(!search.are_tied(&both, &zone));
    });
}
