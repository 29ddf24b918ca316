//! Detectability and isolability of single faults.

use serde::Serialize;

use super::Causality;
use crate::model::StructuralModel;

/// Which faults can be detected, and which isolated from which.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Isolability {
    /// Whether each fault can be detected.
    pub detectable: Vec<bool>,
    /// `isolable[i][j]`: whether fault `i` can be isolated from fault `j`, that is, whether some test can react
    /// to `i` and not to `j`. Never on the diagonal.
    pub isolable: Vec<Vec<bool>>,
}

impl Isolability {
    /// What a choice of tests can do, by the faults to which each of them reacts.
    ///
    /// ```
    /// use fd_structure::analysis::Isolability;
    ///
    /// let two_tests = Isolability::of_tests(&[vec![true, true, false], vec![true, false, false]], 3);
    /// assert_eq!(two_tests.detectable, [true, true, false]);
    /// assert!(two_tests.isolable[0][1] && !two_tests.isolable[1][0]);
    /// ```
    #[must_use]
    pub fn of_tests(signatures: &[Vec<bool>], faults: usize) -> Self {
        let reacts = |test: &Vec<bool>, fault: usize| test.get(fault).copied().unwrap_or(false);
        let row = |i: usize| {
            let isolates = |j: usize| signatures.iter().any(|t| reacts(t, i) && !reacts(t, j));
            (0..faults).map(isolates).collect()
        };
        Self {
            detectable: (0..faults).map(|i| signatures.iter().any(|t| reacts(t, i))).collect(),
            isolable: (0..faults).map(row).collect(),
        }
    }

    /// Whether whatever the other can do, this can do too.
    #[must_use]
    pub fn covers(&self, other: &Self) -> bool {
        let covers = |a: &[bool], b: &[bool]| a.iter().zip(b).all(|(&a, &b)| a || !b);
        covers(&self.detectable, &other.detectable)
            && self.isolable.iter().zip(&other.isolable).all(|(a, b)| covers(a, b))
    }

    /// Faults in groups: those of a group cannot be isolated from each other in either direction. Undetectable
    /// faults are a group of their own, the last one.
    #[must_use]
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for fault in (0..self.detectable.len()).filter(|&fault| self.detectable[fault]) {
            let alike = |group: &&mut Vec<usize>| {
                let apart =
                    |&other: &usize| self.isolable[fault][other] || self.isolable[other][fault];
                !group.iter().any(apart)
            };
            match groups.iter_mut().find(alike) {
                Some(group) => group.push(fault),
                None => groups.push(vec![fault]),
            }
        }
        let hidden: Vec<usize> =
            (0..self.detectable.len()).filter(|&fault| !self.detectable[fault]).collect();
        groups.extend((!hidden.is_empty()).then_some(hidden));
        groups
    }
}

impl StructuralModel {
    /// What the structure allows for single faults (Krysander and Frisk 2008; with restricted causality Frisk
    /// et al. 2012). Takes one decomposition per equation that has a fault.
    ///
    /// ```
    /// use fd_structure::{analysis::Causality, model::StructuralModel};
    ///
    /// let model = StructuralModel::builder("twice measured")
    ///     .equation("a", ["x"], ["y1"])
    ///     .equation("b", ["x"], ["y2"])
    ///     .fault("fa", "a")
    ///     .fault("fb", "b")
    ///     .build()?;
    /// let found = model.isolability(Causality::Mixed);
    /// assert_eq!(found.detectable, [true, true]);
    /// assert_eq!(found.groups(), [[0, 1]]);
    /// # Ok::<(), fd_structure::model::StructureError>(())
    /// ```
    #[must_use]
    pub fn isolability(&self, causality: Causality) -> Isolability {
        let all: Vec<usize> = (0..self.equations.len()).collect();
        let detectable = self.seen_in(&self.overdetermined(&all, causality));
        let mut isolable = vec![vec![false; self.faults.len()]; self.faults.len()];
        let mut done: Vec<(usize, Vec<bool>)> = Vec::new();
        for (j, fault) in self.faults.iter().enumerate() {
            let known = done.iter().find(|(equation, _)| *equation == fault.equation);
            let seen = if let Some((_, seen)) = known {
                seen.clone()
            } else {
                let others: Vec<usize> =
                    all.iter().copied().filter(|&equation| equation != fault.equation).collect();
                self.seen_in(&self.overdetermined(&others, causality))
            };
            for (i, &is_seen) in seen.iter().enumerate() {
                isolable[i][j] = is_seen;
            }
            done.push((fault.equation, seen));
        }
        Isolability { detectable, isolable }
    }

    /// To which faults a test that uses these equations reacts.
    #[must_use]
    pub fn signature(&self, equations: &[usize]) -> Vec<bool> {
        self.faults.iter().map(|fault| equations.contains(&fault.equation)).collect()
    }

    /// As [`StructuralModel::signature`], for equations in order.
    fn seen_in(&self, equations: &[usize]) -> Vec<bool> {
        let is_in = |fault: &crate::model::Fault| equations.binary_search(&fault.equation).is_ok();
        self.faults.iter().map(is_in).collect()
    }
}
