//! Random structures.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use fd_structure::model::StructuralModel;
use proptest::prelude::*;

/// Unknowns of each equation, some pairs of a state and its rate, and equations with a fault.
#[derive(Clone, Debug)]
pub(crate) struct Structure {
    pub(crate) rows: Vec<Vec<usize>>,
    pub(crate) unknowns: usize,
    states: usize,
    faulty: Vec<bool>,
}

/// Structures with at most so many equations and unknowns.
pub(crate) fn structure(equations: usize, unknowns: usize) -> impl Strategy<Value = Structure> {
    (1..=equations, 1..=unknowns, 0..=2_usize).prop_flat_map(|(equations, unknowns, states)| {
        let states = states.min(unknowns / 2).min(equations);
        let row = prop::collection::vec(0..unknowns, 0..=3);
        (
            prop::collection::vec(row, equations - states),
            prop::collection::vec(prop::bool::weighted(0.4), equations - states),
        )
            .prop_map(move |(algebraic, faulty)| {
                let dynamic = (0..states).map(|state| vec![2 * state, 2 * state + 1]);
                let rows = algebraic.into_iter().chain(dynamic).collect();
                Structure { rows, unknowns, states, faulty }
            })
    })
}

impl Structure {
    /// Equations without states and faults first.
    pub(crate) fn model(&self) -> StructuralModel {
        let names: Vec<String> = (0..self.unknowns).map(|x| format!("x{x}")).collect();
        let mut builder = StructuralModel::builder("random");
        let algebraic = self.rows.len() - self.states;
        for (index, row) in self.rows.iter().enumerate() {
            let name = format!("e{index}");
            builder = if index < algebraic {
                builder.equation(name, row.iter().map(|&x| names[x].as_str()), [])
            } else {
                builder.dynamic(name, &names[row[0]], &names[row[1]])
            };
            if self.faulty.get(index) == Some(&true) {
                builder = builder.fault(format!("f{index}"), format!("e{index}"));
            }
        }
        builder.build().unwrap()
    }
}
