//! Overdetermined sets of which equations that only count together are one row.
//!
//! In a structure that is overdetermined throughout, two equations are equivalent when leaving out one of them
//! leaves the other without redundancy. The classes of this relation come and go as wholes, so each is made
//! one row, and the unknowns that occur in no other row go with it (Krysander, Åslund and Nyberg
//! 2008, section IV).

use crate::{
    graph::{Decomposition, Graph, Matching},
    model::{EquationSet, StructuralModel},
};

/// A class of equations.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// The equations, by number in the model.
    pub equations: EquationSet,
    /// Unknowns that other rows have as well.
    columns: Vec<usize>,
    /// Whether the search may take it out. What may not be taken out was taken out elsewhere.
    pub is_removable: bool,
    /// Whether it holds the equation of a fault.
    pub has_fault: bool,
}

/// An overdetermined set without any just determined part.
#[derive(Clone, Debug)]
pub(super) struct Lumped {
    pub rows: Vec<Row>,
}

impl Lumped {
    /// The overdetermined part of a model, each equation a row of its own.
    pub(super) fn of(model: &StructuralModel) -> Self {
        let over = Decomposition::of(&model.graph()).over.rows;
        let row = |equation: usize| Row {
            equations: vec![equation],
            columns: model.equations[equation].unknowns.clone(),
            is_removable: true,
            has_fault: model.faults.iter().any(|fault| fault.equation == equation),
        };
        Self { rows: over.into_iter().map(row).collect() }
    }

    /// All equations, in order.
    pub(super) fn equations(&self) -> EquationSet {
        let mut all: EquationSet =
            self.rows.iter().flat_map(|row| row.equations.iter().copied()).collect();
        all.sort_unstable();
        all
    }

    /// Without one row. If that is a whole class, what is left is overdetermined throughout.
    pub(super) fn without(&self, index: usize) -> Self {
        let rows = self.rows.iter().enumerate().filter(|(i, _)| *i != index);
        Self { rows: rows.map(|(_, row)| row.clone()).collect() }
    }

    /// Rows less unknowns.
    pub(super) fn redundancy(&self) -> usize {
        let mut columns: Vec<usize> =
            self.rows.iter().flat_map(|row| row.columns.iter().copied()).collect();
        columns.sort_unstable();
        columns.dedup();
        self.rows.len().saturating_sub(columns.len())
    }

    /// Lumps the classes of all rows for which `matters`.
    pub(super) fn lump(&self, matters: impl Fn(&Row) -> bool) -> Self {
        let (graph, names) = self.graph();
        let matching = Matching::maximum(&graph);
        let mut class_of: Vec<Option<usize>> = vec![None; self.rows.len()];
        let mut classes: Vec<Vec<usize>> = Vec::new();
        for (index, row) in self.rows.iter().enumerate() {
            if class_of[index].is_some() || !matters(row) {
                continue;
            }
            let class = equivalent(&graph, &matching, index);
            for &member in &class {
                class_of[member] = Some(classes.len());
            }
            classes.push(class);
        }
        // Rows in their old order, a class at the place of its first member.
        let mut rows = Vec::with_capacity(self.rows.len());
        for (index, row) in self.rows.iter().enumerate() {
            match class_of[index].map(|class| &classes[class]) {
                Some(class) if 1 < class.len() => {
                    if class.first() == Some(&index) {
                        rows.push(self.join(class, &graph, &names));
                    }
                }
                _ => rows.push(row.clone()),
            }
        }
        Self { rows }
    }

    /// One row for a class.
    fn join(&self, class: &[usize], graph: &Graph, names: &[usize]) -> Row {
        let mut is_outside = vec![false; graph.columns()];
        for (index, columns) in graph.rows().iter().enumerate() {
            if class.binary_search(&index).is_err() {
                for &column in columns {
                    is_outside[column] = true;
                }
            }
        }
        let members = || class.iter().map(|&index| &self.rows[index]);
        let columns = class.iter().flat_map(|&index| &graph.rows()[index]);
        let shared = columns.filter(|&&column| is_outside[column]);
        let mut columns: Vec<usize> = shared.map(|&column| names[column]).collect();
        columns.sort_unstable();
        columns.dedup();
        Row {
            equations: members().flat_map(|row| row.equations.iter().copied()).collect(),
            columns,
            is_removable: members().all(|row| row.is_removable),
            has_fault: members().any(|row| row.has_fault),
        }
    }

    /// The rows as a graph of the unknowns that occur, and the numbers of those in the model.
    fn graph(&self) -> (Graph, Vec<usize>) {
        let mut names: Vec<usize> =
            self.rows.iter().flat_map(|row| row.columns.iter().copied()).collect();
        names.sort_unstable();
        names.dedup();
        let number = |column: &usize| names.partition_point(|name| name < column);
        let rows = self.rows.iter().map(|row| row.columns.iter().map(number).collect());
        (Graph::new(rows, names.len()), names)
    }
}

/// Rows that lose their redundancy with this one, itself included, in order.
fn equivalent(graph: &Graph, matching: &Matching, row: usize) -> Vec<usize> {
    let mut without = matching.clone();
    without.remove_row(graph, row);
    let others = without.free_rows().into_iter().filter(|&free| free != row);
    let mut is_over = without.reach(graph, others);
    is_over[row] = false;
    (0..is_over.len()).filter(|&index| !is_over[index]).collect()
}
