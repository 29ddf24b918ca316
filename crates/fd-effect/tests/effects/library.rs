//! Effects: identity at zero strength, continuity, no dead candidates, names, files.
use std::collections::{BTreeMap, BTreeSet};

use fd_effect::{Candidate, Kind, SiteRef, with_default_sites};
use fd_sim::{model::Model, simulate::Outcome};
use proptest::prelude::*;

use crate::cases::{Case, PLANTS, effect, name, weaker, without_strength};

const SAMPLES: usize = 300;

#[test]
fn zero_strength_is_exactly_the_nominal_model() {
    for plant in PLANTS {
        let case = Case::new(plant, SAMPLES);
        let expected = case.nominal();
        for candidate in case.simulated() {
            for start in &candidate.starts {
                let phi = without_strength(&candidate, start);
                // `==`: only the sign of a zero may differ.
                let (_, y) = case.apply(&candidate, &phi);
                assert_eq!(y, expected, "{plant}: {}\n{}", name(&candidate), candidate.model);
            }
            // As the file has it.
            assert_eq!(case.run(&candidate.model, &candidate.model.nominal()).1, expected);
        }
    }
}

#[test]
fn every_start_runs_and_the_first_changes_the_outputs() {
    let mut dead = Vec::new();
    for plant in PLANTS {
        let case = Case::new(plant, SAMPLES);
        let nominal = case.nominal();
        for candidate in case.simulated() {
            for (i, start) in candidate.starts.iter().enumerate() {
                let (outcome, y) = case.apply(&candidate, start);
                let distance = case.distance(&y, &nominal);
                if outcome != Outcome::Complete || (i == 0 && distance < 1e-6) {
                    dead.push(format!("{plant}: {} {start:?}: {distance}", name(&candidate)));
                }
            }
        }
    }
    assert!(dead.is_empty(), "{}", dead.join("\n"));
}

#[test]
fn names_units_bounds_and_files_are_in_order() {
    for plant in PLANTS {
        let case = Case::new(plant, 60);
        let mut seen = BTreeSet::new();
        for candidate in case.offers().into_iter().filter_map(Result::ok) {
            assert!(seen.insert(name(&candidate)), "twice: {}", name(&candidate));
            let first = case.model.parameters.len();
            let added = &candidate.model.parameters[first..];
            assert!(candidate.parameters.iter().any(|p| p.is_strength));
            if candidate.kind == Kind::Simulation {
                let names = |p: &fd_sim::model::Parameter| (p.name.clone(), p.unit.clone());
                let declared =
                    candidate.parameters.iter().map(|p| (p.name.clone(), p.unit.clone()));
                assert_eq!(
                    added.iter().map(names).collect::<Vec<_>>(),
                    declared.collect::<Vec<_>>()
                );
                assert!(candidate.spectral.is_none_or(|i| candidate.parameters[i].unit == "Hz"));
            } else {
                assert_eq!(candidate.model, case.model);
            }
            for (i, p) in candidate.parameters.iter().enumerate() {
                assert!(p.low <= p.neutral && p.neutral <= p.high, "{}: {p:?}", name(&candidate));
                assert!(p.low < p.high && p.scale > 0.0, "{}: {p:?}", name(&candidate));
                assert!(candidate.starts.iter().all(|x| p.low <= x[i] && x[i] <= p.high));
                // Shapes of which a positive strength says the direction, and widths, delays,
                // frictions that a negative one would turn into something else.
                let is_signed = effect(&candidate).is_signed();
                assert!(is_signed || !p.is_strength || p.low == 0.0, "{}", name(&candidate));
            }
        }
    }
}

#[test]
fn a_patched_model_file_gives_the_same_bits() {
    for plant in PLANTS {
        let case = Case::new(plant, 100);
        for candidate in case.simulated() {
            let printed: Model = candidate.model.to_string().parse().unwrap();
            assert_eq!(printed, candidate.model);
            let mut theta = case.model.nominal();
            theta.extend(&candidate.starts[0]);
            let bits = |y: &[f64]| y.iter().map(|y| y.to_bits()).collect::<Vec<_>>();
            let y = case.run(&candidate.model, &theta).1;
            assert_eq!(bits(&case.run(&printed, &theta).1), bits(&y), "{}", name(&candidate));
        }
    }
}

#[test]
fn candidates_are_many_but_not_too_many() {
    for plant in PLANTS {
        let case = Case::new(plant, SAMPLES);
        let all: Vec<Candidate> = case.offers().into_iter().filter_map(Result::ok).collect();
        let causes: BTreeSet<String> =
            all.iter().map(|c| format!("{} {:?} {:?}", c.label, c.site, c.partner)).collect();
        let mut refused = BTreeMap::<String, usize>::new();
        for refusal in case.refused() {
            *refused.entry(format!("{}: {}", refusal.label, refusal.reason)).or_default() += 1;
        }
        let starts: usize = all.iter().map(|c| c.starts.len()).sum();
        println!(
            "{plant}: {} causes (effect x site), {} laws, {starts} starts; not testable: {refused:?}",
            causes.len(),
            all.len(),
        );
        assert!((25..=150).contains(&causes.len()), "{plant}: {}", causes.len());
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(24)
    })]

    /// From strength to strength, outputs move by no more than a bounded slope allows.
    #[test]
    fn outputs_are_continuous_in_the_strength(
        plant in 0..PLANTS.len(),
        which in any::<prop::sample::Index>(),
        fraction in 0.0..1.0,
    ) {
        let case = Case::new(PLANTS[plant], SAMPLES);
        let candidates = case.simulated();
        let candidate = &candidates[which.index(candidates.len())];
        prop_assume!(candidate.label != "input-quantisation");
        let start = &candidate.starts[0];
        let (_, here) = case.apply(candidate, &weaker(candidate, start, fraction));
        let (_, near) = case.apply(candidate, &weaker(candidate, start, fraction + 1e-7));
        let distance = case.distance(&here, &near);
        prop_assert!(distance < 1e-3, "{}: {distance}", name(candidate));
    }
}

#[test]
fn weak_effects_change_little() {
    for plant in PLANTS {
        let case = Case::new(plant, SAMPLES);
        let nominal = case.nominal();
        for candidate in case.simulated() {
            for start in &candidate.starts {
                let (_, y) = case.apply(&candidate, &weaker(&candidate, start, 1e-7));
                let distance = case.distance(&y, &nominal);
                assert!(distance < 1e-3, "{plant}: {}: {distance}", name(&candidate));
            }
        }
    }
}

#[test]
fn a_model_without_sites_gets_some() {
    for plant in PLANTS {
        let mut draft = Case::new(plant, 1).model.into_draft();
        draft.sites.clear();
        let bare = Model::try_from(draft).unwrap();
        let case = Case::of(with_default_sites(&bare), 100);
        let expected = case.run(&bare, &bare.nominal()).1;
        let dynamics: Vec<Candidate> = case
            .simulated()
            .into_iter()
            .filter(|c| matches!(c.site, SiteRef::Force(..)) && c.family != "map")
            .collect();
        assert!(dynamics.len() >= 6, "{plant}: {}", dynamics.len());
        for candidate in dynamics {
            let y = case.run(&candidate.model, &candidate.model.nominal()).1;
            assert_eq!(y, expected, "{plant}: {}", name(&candidate));
            assert_ne!(case.apply(&candidate, &candidate.starts[0]).1, expected);
        }
    }
}

/// Who excludes an effect finds its name in the guide.
#[test]
fn the_guide_lists_every_label_and_mechanism() {
    let guide = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/gap.md");
    let guide = std::fs::read_to_string(guide).unwrap();
    let table = guide.split("## Names of effects").nth(1).unwrap().split("\n## ").next().unwrap();
    for effect in fd_effect::library() {
        for name in [effect.label(), effect.family()] {
            assert!(table.contains(&format!("`{name}`")), "{name} is not in the guide");
        }
    }
}
