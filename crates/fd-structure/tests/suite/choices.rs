//! Sensors and tests that are chosen, compared with all choices there are.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use fd_structure::{
    analysis::{Causality, Isolability},
    design::{PlacementError, Requirement, Sensors, select_tests},
    model::StructuralModel,
};
use proptest::prelude::*;

use crate::structures::structure;

/// Multisets of so many of these.
fn choices(of: &[usize], size: usize) -> Vec<Vec<usize>> {
    let Some((first, rest)) = of.split_first() else {
        return if size == 0 { vec![Vec::new()] } else { Vec::new() };
    };
    if size == 0 {
        return vec![Vec::new()];
    }
    let again = choices(of, size - 1).into_iter().map(|mut set| {
        set.insert(0, *first);
        set
    });
    again.chain(choices(rest, size)).collect()
}

/// Whether sensors do what is asked for, judged by the isolability of the larger model.
fn is_enough(
    model: &StructuralModel,
    set: &[usize],
    wanted: &[Requirement],
    may_fail: bool,
) -> bool {
    let larger = model.with_sensors(set, may_fail);
    let found = larger.isolability(Causality::Mixed);
    let old = model.faults().len();
    let new = Requirement::isolate_all(larger.faults().len()).into_iter().filter(|r| match *r {
        Requirement::Detect(i) => old <= i,
        Requirement::Isolate(i, j) => old <= i.max(j),
    });
    wanted.iter().copied().chain(new).all(|requirement| requirement.is_met_by(&found))
}

/// Minimal sets of at most so many sensors.
fn minimal(
    model: &StructuralModel,
    candidates: &[usize],
    wanted: &[Requirement],
    may_fail: bool,
    most: usize,
) -> Vec<Vec<usize>> {
    let mut found: Vec<Vec<usize>> = Vec::new();
    for set in (0..=most).flat_map(|size| choices(candidates, size)) {
        let mut left = |part: &Vec<usize>| {
            let mut rest = set.iter();
            part.iter().all(|x| rest.any(|y| y == x))
        };
        if !found.iter().any(&mut left) && is_enough(model, &set, wanted, may_fail) {
            found.push(set);
        }
    }
    found.sort_unstable();
    found
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, max_global_rejects: 20_000, ..ProptestConfig::default() })]

    #[test]
    fn sensors_are_all_minimal_choices(structure in structure(6, 4), may_fail in any::<bool>()) {
        let model = structure.model();
        prop_assume!(model.decompose().under.columns.is_empty());
        prop_assume!(!model.faults().is_empty());
        let candidates: Vec<usize> = (0..model.unknowns().len()).collect();
        for wanted in [
            Requirement::detect_all(model.faults().len()),
            Requirement::isolate_all(model.faults().len()),
        ] {
            let sensors = Sensors { candidates: candidates.clone(), may_fail };
            let found = model.place_sensors(&wanted, &sensors).unwrap();
            let possible: Vec<Requirement> =
                wanted.iter().copied().filter(|r| !found.impossible.contains(r)).collect();
            // What is called impossible is: three of each do not do it.
            let best = model.with_sensors(&candidates.repeat(3), false).isolability(Causality::Mixed);
            prop_assert!(found.impossible.iter().all(|requirement| !requirement.is_met_by(&best)));
            prop_assert!(found.is_complete);
            let mut small: Vec<Vec<usize>> =
                found.sets.iter().filter(|set| set.len() <= 4).cloned().collect();
            small.sort_unstable();
            prop_assert_eq!(small, minimal(&model, &candidates, &possible, may_fail, 4));
            prop_assert!(found.sets.iter().all(|set| is_enough(&model, set, &possible, may_fail)));
        }
    }

    #[test]
    fn no_fewer_tests_do_it(tests in prop::collection::vec(prop::collection::vec(any::<bool>(), 5), 0..10)) {
        let wanted = Requirement::isolate_all(5);
        let chosen = select_tests(&tests, &wanted);
        prop_assert!(chosen.is_smallest);
        let meets = |bits: usize| {
            let some: Vec<Vec<bool>> = (0..tests.len())
                .filter(|test| (bits >> test) & 1 == 1)
                .map(|test| tests[test].clone())
                .collect();
            let found = Isolability::of_tests(&some, 5);
            wanted.iter().all(|r| chosen.unmet.contains(r) || r.is_met_by(&found))
        };
        let of_chosen = chosen.tests.iter().fold(0_usize, |bits, test| bits | 1 << test);
        prop_assert!(meets(of_chosen));
        let fewest = (0..1_usize << tests.len()).filter(|&bits| meets(bits)).map(usize::count_ones).min();
        prop_assert_eq!(u32::try_from(chosen.tests.len()).ok(), fewest);
        let all = Isolability::of_tests(&tests, 5);
        prop_assert!(chosen.unmet.iter().all(|requirement| !requirement.is_met_by(&all)));
    }
}

#[test]
fn a_model_that_is_underdetermined_gets_no_sensors() {
    let model = StructuralModel::builder("open").equation("e", ["a", "b"], []).fault("f", "e");
    let model = model.build().unwrap();
    let sensors = Sensors { candidates: vec![0], may_fail: false };
    let error = model.place_sensors(&Requirement::detect_all(1), &sensors).unwrap_err();
    assert_eq!(error, PlacementError::Underdetermined(vec!["a".to_owned(), "b".to_owned()]));
    let sensors = Sensors { candidates: vec![7], may_fail: false };
    let error = model.place_sensors(&Requirement::detect_all(1), &sensors).unwrap_err();
    assert!(error.to_string().contains("no unknown number 7; there are 2"), "{error}");
}
