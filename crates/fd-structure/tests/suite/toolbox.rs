//! The same answers as the Fault Diagnosis Toolbox (Frisk, Krysander and Jung 2017), version 0.12.5, on its three
//! examples and on 50 random structures. `golden/make.py` makes the file that is compared with.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::collections::BTreeMap;

use fd_structure::{
    analysis::Causality, generator::Flow, model::StructuralModel, redundancy::Supports,
};
use serde_json::Value;

const GOLDEN: &str = include_str!("../golden/toolbox.json");

fn golden() -> Vec<Value> {
    serde_json::from_str(GOLDEN).unwrap()
}

fn numbers(value: &Value) -> Vec<usize> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|n| usize::try_from(n.as_u64().unwrap()).unwrap())
        .collect()
}

fn sets(value: &Value) -> Vec<Vec<usize>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

fn texts(value: &Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect()
}

/// Equations keep their numbers; what is compared are sets of those.
fn model(case: &Value) -> StructuralModel {
    let mut builder = StructuralModel::builder(case["name"].as_str().unwrap());
    for (index, row) in texts(&case["x"]).into_iter().enumerate() {
        let with = |digit: char| {
            let places = row.chars().enumerate().filter(move |(_, d)| *d == digit);
            places.map(|(x, _)| format!("x{x}")).collect::<Vec<_>>()
        };
        let name = format!("e{index}");
        let (states, rates) = (with('2'), with('3'));
        builder = if let ([state], [rate]) = (states.as_slice(), rates.as_slice()) {
            builder.dynamic(name, state, rate)
        } else {
            let unknowns = with('1');
            builder.equation(name, unknowns.iter().map(String::as_str), [])
        };
    }
    for (index, equation) in numbers(&case["f"]).into_iter().enumerate() {
        builder = builder.fault(format!("f{index}"), format!("e{equation}"));
    }
    builder.build().unwrap()
}

#[test]
fn the_same_minimal_overdetermined_sets() {
    let cases = golden();
    assert_eq!(cases.len(), 53);
    for case in &cases {
        let model = model(case);
        let found = model.mso_sets(10_000);
        assert!(found.is_complete, "{}", case["name"]);
        assert_eq!(found.sets, sets(&case["mso"]), "{}", case["name"]);
        let redundancy = usize::try_from(case["redundancy"].as_u64().unwrap()).unwrap();
        assert_eq!(model.decompose().redundancy(), redundancy, "{}", case["name"]);
    }
}

#[test]
fn the_numbers_of_sets_that_are_published() {
    // Frisk, Krysander and Jung (2017) name 6 for the three tanks and 9 for the induction motor.
    let counts: BTreeMap<String, usize> = golden()
        .iter()
        .take(3)
        .map(|case| {
            let model = model(case);
            (model.name().to_owned(), model.mso_sets(100).sets.len())
        })
        .collect();
    let expected = [("Electric motor", 3), ("Induction motor", 9), ("Three Tank System", 6)];
    assert_eq!(counts, expected.map(|(name, count)| (name.to_owned(), count)).into());
}

#[test]
fn the_same_test_equation_supports() {
    for case in &golden() {
        let found = model(case).test_supports(Supports::Minimal, 10_000);
        assert!(found.is_complete, "{}", case["name"]);
        assert_eq!(found.sets, sets(&case["mtes"]), "{}", case["name"]);
    }
}

#[test]
fn the_same_detectability_and_isolability_in_every_causality() {
    let keys =
        [(Causality::Mixed, "mixed"), (Causality::Integral, "int"), (Causality::Derivative, "der")];
    for case in &golden() {
        let model = model(case);
        for (causality, key) in keys {
            let found = model.isolability(causality);
            let expected = &case[key];
            let detectable: Vec<usize> = found.detectable.iter().map(|&d| usize::from(d)).collect();
            assert_eq!(detectable, numbers(&expected["detectable"]), "{} {key}", case["name"]);
            let isolability: Vec<String> = found
                .isolable
                .iter()
                .map(|row| row.iter().map(|&told| if told { '0' } else { '1' }).collect())
                .collect();
            assert_eq!(isolability, texts(&expected["isolability"]), "{} {key}", case["name"]);
        }
    }
}

#[test]
fn the_same_causality_of_every_residual() {
    let (mut compared, mut seen) = (0, BTreeMap::new());
    for case in &golden() {
        let model = model(case);
        for (set, flows) in sets(&case["mso"]).iter().zip(texts(&case["sweep"])) {
            let flows: Vec<&str> = flows.split(' ').collect();
            assert_eq!(set.len(), flows.len());
            for (&residual, expected) in set.iter().zip(flows) {
                let sequence = model.sequence(set, residual).unwrap();
                let flow = match sequence.flow {
                    Flow::Algebraic => "algebraic",
                    Flow::Integral => "int",
                    Flow::Derivative => "der",
                    Flow::Mixed => "mixed",
                };
                assert_eq!(flow, expected, "{}: {residual} of {set:?}", case["name"]);
                *seen.entry(flow).or_insert(0) += 1;
                compared += 1;
            }
        }
    }
    // All four occur, so that none of them is right by default.
    assert!(compared > 1_000 && seen.len() == 4, "{compared}: {seen:?}");
}
