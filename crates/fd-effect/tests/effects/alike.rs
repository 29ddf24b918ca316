//! One law at several places, with one strength.

use std::collections::BTreeSet;

use fd_effect::{Candidate, EverySite, SiteRef, Suspects, library};

use crate::cases::{Case, PLANTS, effect, name};

/// Two carriages on rails of their own, measured in one unit.
const GANTRY: &str = r#"
version = 1
kind = "equations"
name = "gantry"
sample_time = 0.02
inputs = { a = { unit = "N" }, b = { unit = "N" } }
outputs = { p = { unit = "m/s", value = "v" }, q = { unit = "m/s", value = "w" } }
[states]
v = { unit = "m/s", initial = 0.0, derivative = "a - v" }
w = { unit = "m/s", initial = 0.0, derivative = "2*b - 3*w" }
[sites]
x = { unit = "N", enters = { v = "1" }, velocity = "v" }
y = { unit = "N", enters = { w = "2" }, velocity = "w" }
"#;

fn gantry() -> Case {
    Case::of(GANTRY.parse().unwrap(), 300)
}

fn alike(case: &Case) -> Vec<Candidate> {
    let is_alike = |candidate: &Candidate| matches!(candidate.site, SiteRef::Alike(..));
    case.simulated().into_iter().filter(is_alike).collect()
}

/// The law at each of its places, one on top of the other, each with a strength of its own that is the same.
fn one_by_one(case: &Case, all: &Candidate, values: &[f64]) -> Vec<f64> {
    let (mut model, mut theta) = (case.model.clone(), case.model.nominal());
    for site in all.site.each() {
        let offers = effect(all).candidates(&model, &case.scales);
        let is_it = |candidate: &Candidate| candidate.law == all.law && candidate.site == *site;
        let own = offers.into_iter().flatten().find(is_it).unwrap();
        theta.extend(values);
        model = own.model;
    }
    case.run(&model, &theta).1
}

#[test]
fn a_law_at_all_places_does_what_it_does_at_each_of_them() {
    let plants = PLANTS.map(|plant| Case::new(plant, 200));
    let mut labels = BTreeSet::new();
    for case in plants.into_iter().chain([gantry()]) {
        for all in alike(&case) {
            labels.insert(all.label);
            for start in &all.starts {
                let (_, together) = case.apply(&all, start);
                assert_eq!(together, one_by_one(&case, &all, start), "{}", name(&all));
            }
        }
    }
    let often: BTreeSet<&str> =
        library().iter().filter(|e| e.is_often_alike()).map(|e| e.label()).collect();
    assert_eq!(labels, often, "each effect that is often alike is so somewhere");
}

#[test]
fn names_speak_of_no_place_and_bounds_hold_everywhere() {
    let case = gantry();
    let all = alike(&case);
    let late = all.iter().find(|all| all.label == "input-delay").unwrap();
    assert_eq!((late.site.name(), late.parameters[0].name.as_str()), (Some("a, b"), "alike_delay"));
    let json = serde_json::to_string(&late.site).unwrap();
    assert_eq!(json, r#"{"kind":"inputs","name":"a, b"}"#);
    let rub = all.iter().find(|all| all.label == "coulomb-friction").unwrap();
    for site in rub.site.each() {
        let offers = case.simulated().into_iter();
        let is_it = |c: &Candidate| c.label == rub.label && c.law == rub.law && c.site == *site;
        let own = offers.into_iter().find(is_it).unwrap();
        for (own, all) in own.parameters.iter().zip(&rub.parameters) {
            assert!(all.low <= own.low && own.high <= all.high && all.scale <= own.scale);
        }
    }
}

#[test]
fn who_excludes_one_place_excludes_all_that_it_is_alike_with() {
    let Case { model, scales, .. } = gantry();
    let every = EverySite::new(library(), &model, scales).without(&["input-delay@b".to_owned()]);
    let offers = every.alone();
    let late = offers.iter().flatten().filter(|candidate| candidate.label == "input-delay");
    // Both of its laws.
    assert_eq!(late.map(|late| late.site.name().unwrap()).collect::<Vec<_>>(), ["a", "a"]);
    let each = every.one_by_one().alone();
    assert!(each.iter().flatten().all(|candidate| candidate.site.each().len() == 1));
}

/// One more law beside one that is alike sees what that has made of the model.
#[test]
fn others_can_be_beside_it() {
    let case = gantry();
    let all = alike(&case);
    let rub = all.iter().find(|all| all.label == "coulomb-friction").unwrap();
    let every = EverySite::new(library(), &case.model, case.scales.clone());
    let beside = every.beside(rub);
    let late: Vec<&Candidate> =
        beside.iter().flatten().filter(|candidate| candidate.label == "input-delay").collect();
    // Of each there is the law that begins from rest as well.
    assert_eq!(late.len(), 5);
    for candidate in late {
        let names: Vec<&str> = candidate.model.parameters.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names[..1], [rub.parameters[0].name.as_str()], "{names:?}");
    }
}
