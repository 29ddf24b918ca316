//! What holds for every structure: compared with definitions that are spelled out over all subsets.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use fd_structure::{
    analysis::{Causality, Isolability},
    graph::{Decomposition, Graph, Matching},
    model::StructuralModel,
    redundancy::Supports,
};
use proptest::prelude::*;

use crate::structures::{Structure, structure};

/// Sets of equations as bits, all of them.
fn subsets(equations: usize) -> impl Iterator<Item = Vec<usize>> {
    (0..1_usize << equations)
        .map(move |bits| (0..equations).filter(|e| (bits >> e) & 1 == 1).collect())
}

/// Structural rank, by trying rows one after the other (Kuhn's algorithm): another one than the library's.
fn rank(model: &StructuralModel, equations: &[usize]) -> usize {
    fn place(rows: &[Vec<usize>], row: usize, seen: &mut [bool], of: &mut [Option<usize>]) -> bool {
        rows[row].iter().any(|&column| {
            if std::mem::replace(&mut seen[column], true) {
                return false;
            }
            let is_free = match of[column] {
                None => true,
                Some(other) => place(rows, other, seen, of),
            };
            if is_free {
                of[column] = Some(row);
            }
            is_free
        })
    }
    let graph = model.graph_of(equations);
    let mut of = vec![None; graph.columns()];
    let rows = 0..graph.rows().len();
    rows.filter(|&row| place(graph.rows(), row, &mut vec![false; of.len()], &mut of)).count()
}

/// By definition: overdetermined, and every proper subset is not.
fn is_mso(model: &StructuralModel, set: &[usize]) -> bool {
    let is_over = |set: &[usize]| rank(model, set) < set.len();
    let without = |left_out: usize| -> Vec<usize> {
        set.iter().copied().filter(|&equation| equation != left_out).collect()
    };
    is_over(set) && set.iter().all(|&equation| !is_over(&without(equation)))
}

/// By definition: every equation has redundancy.
fn is_overdetermined_throughout(model: &StructuralModel, set: &[usize]) -> bool {
    let full = rank(model, set);
    full < set.len()
        && set.iter().all(|&left_out| {
            let rest: Vec<usize> = set.iter().copied().filter(|&e| e != left_out).collect();
            rank(model, &rest) == full
        })
}

/// Test equation supports by their definition: overdetermined throughout with some fault, and whatever is larger and
/// still so reacts to more faults.
fn supports_by_definition(model: &StructuralModel) -> Vec<Vec<usize>> {
    let reacting: Vec<(Vec<usize>, Vec<bool>)> = subsets(model.equations().len())
        .filter(|set| is_overdetermined_throughout(model, set))
        .map(|set| (model.signature(&set), set))
        .filter(|(signature, _)| signature.contains(&true))
        .map(|(signature, set)| (set, signature))
        .collect();
    let is_within = |a: &[usize], b: &[usize]| a.len() < b.len() && a.iter().all(|e| b.contains(e));
    let supports = reacting.iter().filter(|(set, signature)| {
        !reacting.iter().any(|(other, same)| same == signature && is_within(set, other))
    });
    let mut supports: Vec<Vec<usize>> = supports.map(|(set, _)| set.clone()).collect();
    supports.sort_unstable();
    supports
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]

    #[test]
    fn the_mso_sets_are_those_of_the_definition(structure in structure(9, 7)) {
        let model = structure.model();
        let mut expected: Vec<Vec<usize>> =
            subsets(model.equations().len()).filter(|set| is_mso(&model, set)).collect();
        expected.sort_unstable();
        let found = model.mso_sets(usize::MAX);
        prop_assert!(found.is_complete);
        prop_assert_eq!(&found.sets, &expected);
        for set in &found.sets {
            prop_assert_eq!(model.redundancy(set), 1);
        }
    }

    #[test]
    fn test_supports_are_those_of_the_definition(structure in structure(8, 6)) {
        let model = structure.model();
        let expected = supports_by_definition(&model);
        prop_assert_eq!(&model.test_supports(Supports::All, 10_000).sets, &expected);
        let is_part = |a: &Vec<usize>, b: &Vec<usize>| a != b && a.iter().all(|e| b.contains(e));
        let minimal: Vec<Vec<usize>> =
            expected.iter().filter(|set| !expected.iter().any(|o| is_part(o, set))).cloned().collect();
        prop_assert_eq!(&model.test_supports(Supports::Minimal, 10_000).sets, &minimal);
    }

    #[test]
    fn all_sets_together_isolate_what_the_structure_allows(structure in structure(9, 7)) {
        let model = structure.model();
        let found = model.isolability(Causality::Mixed);
        let of_sets = |sets: &[Vec<usize>]| {
            let signatures: Vec<Vec<bool>> = sets.iter().map(|set| model.signature(set)).collect();
            Isolability::of_tests(&signatures, model.faults().len())
        };
        prop_assert_eq!(&of_sets(&model.mso_sets(usize::MAX).sets), &found);
        prop_assert_eq!(&of_sets(&model.test_supports(Supports::Minimal, 10_000).sets), &found);
    }

    #[test]
    fn isolability_is_reflexive_and_coarser_with_restricted_causality(structure in structure(12, 9)) {
        let model = structure.model();
        let mixed = model.isolability(Causality::Mixed);
        for causality in Causality::ALL {
            let found = model.isolability(causality);
            prop_assert!(mixed.covers(&found));
            for (fault, row) in found.isolable.iter().enumerate() {
                prop_assert!(!row[fault]);
                // Whatever is isolated from anything is detected.
                prop_assert!(found.detectable[fault] || !row.contains(&true));
            }
        }
    }

    #[test]
    fn parts_do_not_depend_on_the_order(structure in structure(12, 12), seed in any::<u64>()) {
        let Structure { rows, unknowns, .. } = &structure;
        let (by_row, by_column) = (shuffled(rows.len(), seed), shuffled(*unknowns, !seed));
        let moved = by_row.iter().map(|&row| rows[row].iter().map(|&x| by_column[x]).collect());
        let (plain, moved) = (
            Decomposition::of(&Graph::new(rows.clone(), *unknowns)),
            Decomposition::of(&Graph::new(moved, *unknowns)),
        );
        let back = |part: &fd_structure::graph::Part| {
            let mut rows: Vec<usize> = part.rows.iter().map(|&row| by_row[row]).collect();
            let column = |&x: &usize| by_column.iter().position(|&y| y == x).unwrap();
            let mut columns: Vec<usize> = part.columns.iter().map(column).collect();
            rows.sort_unstable();
            columns.sort_unstable();
            (rows, columns)
        };
        let as_is = |part: &fd_structure::graph::Part| (part.rows.clone(), part.columns.clone());
        prop_assert_eq!(back(&moved.over), as_is(&plain.over));
        prop_assert_eq!(back(&moved.under), as_is(&plain.under));
        let mut blocks: Vec<_> = moved.just.iter().map(back).collect();
        let mut expected: Vec<_> = plain.just.iter().map(as_is).collect();
        blocks.sort_unstable();
        expected.sort_unstable();
        prop_assert_eq!(blocks, expected);
    }

    #[test]
    fn parts_are_a_partition_in_order_of_computation(structure in structure(12, 12)) {
        let graph = Graph::new(structure.rows.clone(), structure.unknowns);
        let parts = Decomposition::of(&graph);
        let all = || parts.just.iter().chain([&parts.over, &parts.under]);
        let mut rows: Vec<usize> = all().flat_map(|part| part.rows.clone()).collect();
        let mut columns: Vec<usize> = all().flat_map(|part| part.columns.clone()).collect();
        rows.sort_unstable();
        columns.sort_unstable();
        prop_assert_eq!(rows, (0..graph.rows().len()).collect::<Vec<_>>());
        prop_assert_eq!(columns, (0..graph.columns()).collect::<Vec<_>>());
        prop_assert_eq!(
            parts.over.columns.len() + parts.just.iter().map(|part| part.rows.len()).sum::<usize>()
                + parts.under.rows.len(),
            Matching::maximum(&graph).size()
        );
        // The overdetermined part knows no other unknowns; a block knows those before it.
        let mut known = parts.over.columns.clone();
        for part in [&parts.over].into_iter().chain(&parts.just) {
            known.extend(&part.columns);
            for &row in &part.rows {
                prop_assert!(graph.rows()[row].iter().all(|x| known.contains(x)));
            }
        }
    }

    #[test]
    fn the_matching_is_as_large_as_another_algorithm_makes_it(structure in structure(14, 14)) {
        let model = structure.model();
        let all: Vec<usize> = (0..model.equations().len()).collect();
        prop_assert_eq!(Matching::maximum(&model.graph()).size(), rank(&model, &all));
    }
}

/// Numbers in an order that the seed decides.
fn shuffled(count: usize, mut seed: u64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        order.swap(last, usize::try_from(seed >> 33).unwrap() % (last + 1));
    }
    order
}
