//! The fewest tests that do what all of them can do.

use serde::Serialize;

use super::Requirement;

/// How many partial choices are looked at before the best one so far has to do.
const MOST_NODES: usize = 200_000;

/// Some of many tests.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Selection {
    /// The chosen tests, by number, in order.
    pub tests: Vec<usize>,
    /// Whether no smaller choice meets the requirements. Otherwise the search was given up, and the choice is the
    /// best it had; at worst that of the greedy rule.
    pub is_smallest: bool,
    /// Requirements that all tests together do not meet.
    pub unmet: Vec<Requirement>,
}

/// Chooses tests, given the faults to which each reacts, such that all requirements are met that they can meet at all.
///
/// Each requirement is the set of tests that meet it, and the choice a hitting set of these: the smallest one by branch
/// and bound, started from the greedy one (a test that meets most of what is left, again and again).
///
/// ```
/// use fd_structure::design::{Requirement, select_tests};
///
/// let reacts = [vec![true, true], vec![true, false], vec![false, true]];
/// let chosen = select_tests(&reacts, &Requirement::isolate_all(2));
/// assert_eq!(chosen.tests, [1, 2]);
/// assert!(chosen.is_smallest && chosen.unmet.is_empty());
/// ```
#[must_use]
pub fn select_tests(signatures: &[Vec<bool>], requirements: &[Requirement]) -> Selection {
    let (mut sets, mut unmet) = (Vec::new(), Vec::new());
    for &requirement in requirements {
        let reacts = |test: usize, fault: usize| signatures[test].get(fault) == Some(&true);
        let meets = |&test: &usize| match requirement {
            Requirement::Detect(i) => reacts(test, i),
            Requirement::Isolate(i, j) => reacts(test, i) && !reacts(test, j),
        };
        let set: Vec<usize> = (0..signatures.len()).filter(meets).collect();
        if set.is_empty() { unmet.push(requirement) } else { sets.push(set) }
    }
    let sets = smallest(sets);
    let mut search = Search { best: greedy(&sets), nodes: MOST_NODES, sets };
    let all: Vec<usize> = (0..search.sets.len()).collect();
    search.visit(&all, &mut Vec::new());
    let mut tests = search.best;
    tests.sort_unstable();
    Selection { tests, is_smallest: 0 < search.nodes, unmet }
}

/// Without those that contain another one: whatever hits that one hits them.
fn smallest(mut sets: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    sets.sort_unstable_by(|a, b| (a.len(), a).cmp(&(b.len(), b)));
    let mut kept: Vec<Vec<usize>> = Vec::new();
    for set in sets {
        let contains = |part: &Vec<usize>| part.iter().all(|test| set.binary_search(test).is_ok());
        if !kept.iter().any(contains) {
            kept.push(set);
        }
    }
    kept
}

/// The test that is in most of these sets.
fn commonest(sets: &[Vec<usize>], open: &[usize]) -> Option<usize> {
    let tests = open.iter().flat_map(|&set| sets[set].iter().copied());
    let most = tests.clone().max()?;
    let mut counts = vec![0; most + 1];
    tests.for_each(|test| counts[test] += 1);
    // The first of several.
    (0..counts.len()).rev().max_by_key(|&test| counts[test])
}

fn greedy(sets: &[Vec<usize>]) -> Vec<usize> {
    let mut open: Vec<usize> = (0..sets.len()).collect();
    let mut chosen = Vec::new();
    while let Some(test) = commonest(sets, &open) {
        chosen.push(test);
        open.retain(|&set| sets[set].binary_search(&test).is_err());
    }
    chosen
}

struct Search {
    sets: Vec<Vec<usize>>,
    best: Vec<usize>,
    nodes: usize,
}

impl Search {
    fn visit(&mut self, open: &[usize], chosen: &mut Vec<usize>) {
        self.nodes = self.nodes.saturating_sub(1);
        if open.is_empty() {
            if chosen.len() < self.best.len() {
                self.best.clone_from(chosen);
            }
            return;
        }
        if self.nodes == 0 || self.best.len() <= chosen.len() + self.at_least(open) {
            return;
        }
        // One of the smallest set has to be chosen.
        let Some(&set) = open.iter().min_by_key(|&&set| self.sets[set].len()) else { return };
        for test in self.sets[set].clone() {
            let left = open.iter().copied().filter(|&s| self.sets[s].binary_search(&test).is_err());
            let left: Vec<usize> = left.collect();
            chosen.push(test);
            self.visit(&left, chosen);
            chosen.pop();
        }
    }

    /// Sets that have nothing in common need a test each.
    fn at_least(&self, open: &[usize]) -> usize {
        let mut apart: Vec<&Vec<usize>> = Vec::new();
        for &set in open {
            let set = &self.sets[set];
            let meets = |other: &&Vec<usize>| other.iter().any(|t| set.binary_search(t).is_ok());
            if !apart.iter().any(meets) {
                apart.push(set);
            }
        }
        apart.len()
    }
}
