//! Published structures with published answers, apart from those that `toolbox` has. Sources: `docs/results/published.md`.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::collections::{BTreeMap, BTreeSet};

use fd_structure::{
    analysis::Causality,
    design::{Requirement, Sensors},
    model::StructuralModel,
    redundancy::Supports,
};

/// One line per equation `e1`, `e2` and so on: the faults in it, a colon, and its unknowns, or `state < rate`.
fn read(name: &str, lines: &str) -> StructuralModel {
    let mut builder = StructuralModel::builder(name);
    for (number, line) in (1..).zip(lines.trim().lines()) {
        let equation = format!("e{number}");
        let (faults, line) = line.split_once(':').unwrap_or(("", line));
        builder = match line.split_once(" < ") {
            Some((state, rate)) => builder.dynamic(&equation, state.trim(), rate.trim()),
            None => builder.equation(&equation, line.split_whitespace(), []),
        };
        for fault in faults.split_whitespace() {
            builder = builder.fault(fault, &equation);
        }
    }
    builder.build().unwrap()
}

/// Sets of equations as the sources number them: from one on.
fn numbered(sets: &[Vec<usize>]) -> BTreeSet<Vec<usize>> {
    sets.iter().map(|set| set.iter().map(|e| e + 1).collect()).collect()
}

/// To which faults each fault may also be put down, itself among them: the dots in the rows of an isolability matrix.
fn dots(model: &StructuralModel, causality: Causality) -> BTreeMap<String, BTreeSet<String>> {
    let found = model.isolability(causality);
    assert!(found.detectable.iter().all(|&is| is), "{:?}", found.detectable);
    let name = |fault: usize| model.faults()[fault].name.clone();
    let row = |told: &Vec<bool>| (0..told.len()).filter(|&j| !told[j]).map(name).collect();
    found.isolable.iter().enumerate().map(|(i, told)| (name(i), row(told))).collect()
}

/// Dots of faults that look alike in groups, as words.
fn alike(groups: &[&str]) -> BTreeMap<String, BTreeSet<String>> {
    let names = |group: &str| group.split(' ').map(str::to_owned).collect::<BTreeSet<_>>();
    let members = groups.iter().flat_map(|&group| group.split(' ').map(move |one| (one, group)));
    members.map(|(one, group)| (one.to_owned(), names(group))).collect()
}

fn unknowns_but(model: &StructuralModel, left_out: &str) -> Vec<usize> {
    (0..model.unknowns().len()).filter(|&x| model.unknowns()[x] != left_out).collect()
}

/// All that can be isolated with three sensors of each of these.
fn most(model: &StructuralModel, candidates: &[usize]) -> Vec<Requirement> {
    let at_best = model.with_sensors(&candidates.repeat(3), false).isolability(Causality::Mixed);
    let all = Requirement::isolate_all(model.faults().len());
    all.into_iter().filter(|one| one.is_met_by(&at_best)).collect()
}

/// All minimal sets of sensors that meet these requirements, by name.
fn placed(
    model: &StructuralModel,
    candidates: &[usize],
    wanted: &[Requirement],
    may_fail: bool,
) -> BTreeSet<Vec<String>> {
    let sensors = Sensors { candidates: candidates.to_vec(), may_fail };
    let found = model.place_sensors(wanted, &sensors).unwrap();
    assert!(found.is_complete && found.impossible.is_empty(), "{:?}", found.impossible);
    let names = |set: &Vec<usize>| {
        let mut names: Vec<_> = set.iter().map(|&x| model.unknowns()[x].clone()).collect();
        names.sort_unstable();
        names
    };
    found.sets.iter().map(names).collect()
}

fn words(sets: &[&str]) -> BTreeSet<Vec<String>> {
    sets.iter().map(|set| set.split(' ').map(str::to_owned).collect()).collect()
}

/// Krysander, Åslund and Frisk (2010): three states, three sensors, five faults.
#[test]
fn test_supports_of_three_states() {
    let model = read("three states", "f1: x1\nf2: x1 x2 x3\nx2 x3\nf3: x2\nf4: x2\nf5: x3");
    let minimal = [
        vec![3, 5, 6],
        vec![3, 4, 6],
        vec![4, 5],
        vec![1, 2, 3, 6],
        vec![1, 2, 3, 5],
        vec![1, 2, 3, 4],
    ];
    let only_overdetermined = [vec![1, 2, 5, 6], vec![1, 2, 4, 6]];
    let larger = [
        vec![3, 4, 5, 6],
        vec![1, 2, 3, 5, 6],
        vec![1, 2, 3, 4, 6],
        vec![1, 2, 3, 4, 5],
        vec![1, 2, 3, 4, 5, 6],
    ];
    let sets = |groups: &[&[Vec<usize>]]| -> BTreeSet<Vec<usize>> {
        groups.iter().flat_map(|group| group.iter().cloned()).collect()
    };
    let msos = model.mso_sets(100);
    assert!(msos.is_complete);
    assert_eq!(numbered(&msos.sets), sets(&[&minimal, &only_overdetermined]));
    let mtes = model.test_supports(Supports::Minimal, 100);
    assert_eq!(numbered(&mtes.sets), sets(&[&minimal]));
    let tes = model.test_supports(Supports::All, 100);
    assert_eq!(numbered(&tes.sets), sets(&[&minimal, &larger]));
}

/// Commault, Dion and Agha (2006), as the toolbox's documentation has it.
#[test]
fn sensors_of_commault() {
    let model = read(
        "Commault",
        "f1: x5\nf2: x7\nf4: x6\nx1 x5 x7\nf3: x2 x6\nx1 x2 x3\nx1 x2 x4\nx3\nx3 x4\nx4",
    );
    assert_eq!(model.decompose().redundancy(), 3);
    assert_eq!(dots(&model, Causality::Mixed), alike(&["f1 f2", "f3 f4"]));
    let all = unknowns_but(&model, "");
    let isolate = Requirement::isolate_all(4);
    assert_eq!(placed(&model, &all, &isolate, false), words(&["x5 x6", "x6 x7"]));
}

/// Krysander and Frisk (2008): five states without a sensor.
#[test]
fn sensors_of_krysander_and_frisk() {
    let model = read("five states", "x1 x2 x5\nx2 x3 x4\nf1 f2: x3 x5\nf3: x4 x5\nf4: x5");
    let all = unknowns_but(&model, "");
    let detect = Requirement::detect_all(4);
    assert_eq!(placed(&model, &all, &detect, false), words(&["x1", "x2", "x3 x4"]));
    let x3 = model.unknowns().iter().position(|x| x == "x3").unwrap();
    let measured = model.with_sensors(&[x3], false).isolability(Causality::Mixed);
    assert_eq!(measured.detectable, [true, true, false, true]);
    let best = most(&model, &all);
    let published = words(&["x1 x3", "x1 x4", "x2 x3", "x2 x4", "x3 x4"]);
    assert_eq!(placed(&model, &all, &best, false), published);
    // With sensors that may fail one of the answers is published: the first sensor twice.
    let guarded = placed(&model, &all, &best, true);
    assert!(guarded.is_superset(&words(&["x1 x1 x3"])), "{guarded:?}");
}

/// Düştegör, Frisk, Cocquempot, Krysander and Staroswiecki (2006): the valve of the DAMADICS benchmark.
#[test]
fn sensors_of_the_damadics_valve() {
    let model = read(
        "valve",
        "f4 f11: Ps xf10 x Fvc\nf8: xh x\nf1 f5: Qv xh DeltaP\nDeltaP-a xh P1 Pv\nPv T1\nDeltaP P1 P2 DeltaP-a\n\
         Fvc P1 xh P2 DeltaP-a Pv\nf18: Qv3 P1 P2\nQc Ps xh\nf9 f16: Qc Ps xf10 Pz\nQ Qv Qv3\nf13: xh\nP1\nP2\n\
         f7: T1\nf12:\nf10: xf10",
    );
    let candidates = unknowns_but(&model, "xf10");
    let detect = Requirement::detect_all(12);
    assert_eq!(placed(&model, &candidates, &detect, false), words(&["Pz Q", "Pz Qv Qv3"]));
    let best = placed(&model, &candidates, &most(&model, &candidates), false);
    // Published is their number: six of five sensors each.
    assert!(best.len() == 6 && best.iter().all(|set| set.len() == 5), "{best:?}");
    let groups = ["f1 f5", "f4 f11", "f9 f16", "f7", "f8", "f10", "f12", "f13", "f18"];
    for set in &best {
        let number = |name: &String| model.unknowns().iter().position(|x| x == name).unwrap();
        let measured: Vec<usize> = set.iter().map(number).collect();
        let larger = model.with_sensors(&measured, false);
        assert_eq!(dots(&larger, Causality::Mixed), alike(&groups));
    }
}

/// Model (2) of the toolbox's manual: five states, three of them measured.
#[test]
fn sets_of_the_manual() {
    let model = read(
        "manual",
        "dx1 x1 x2 x5\ndx2 x2 x3 x4\nf1 f2: dx3 x3 x5\nf3: dx4 x4 x5\nf4: dx5 x5\nx1\nx2\nx3\n\
         x1 < dx1\nx2 < dx2\nx3 < dx3\nx4 < dx4\nx5 < dx5",
    );
    let msos = numbered(&model.mso_sets(100).sets);
    assert_eq!(msos.len(), 11);
    assert!(msos.contains(&vec![3, 5, 8, 11, 13]), "{msos:?}");
}
