//! The Dulmage-Mendelsohn decomposition.

use serde::Serialize;

use super::{Graph, Matching, components::components};

/// Some rows and some columns.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Part {
    /// Equations, by number.
    pub rows: Vec<usize>,
    /// Unknowns, by number.
    pub columns: Vec<usize>,
}

/// The canonical parts of a structure (Dulmage and Mendelsohn 1958): they are the same for every maximum
/// matching.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Decomposition {
    /// `M-`: more unknowns than equations.
    pub under: Part,
    /// `M0`: as many equations as unknowns, in blocks that cannot be solved one part after the other.
    /// Each block needs at most unknowns of blocks before it and of the overdetermined part.
    pub just: Vec<Part>,
    /// `M+`: more equations than unknowns. Only here can a fault be seen.
    pub over: Part,
}

impl Decomposition {
    /// Decomposes a graph. Takes as long as a maximum matching.
    ///
    /// ```
    /// use fd_structure::graph::{Decomposition, Graph};
    ///
    /// // x0 is known twice, x1 follows from it, and for x2 and x3 there is one equation.
    /// let graph = Graph::new([vec![0], vec![0], vec![0, 1], vec![1, 2, 3]], 4);
    /// let parts = Decomposition::of(&graph);
    /// assert_eq!(parts.over.rows, [0, 1]);
    /// assert_eq!((parts.just.len(), parts.just[0].columns.as_slice()), (1, &[1][..]));
    /// assert_eq!(parts.under.columns, [2, 3]);
    /// ```
    #[must_use]
    pub fn of(graph: &Graph) -> Self {
        let matching = Matching::maximum(graph);
        let is_over = matching.reach(graph, matching.free_rows());
        // The mirror image: from free columns along any row to the column that has it.
        let is_under = reach_from_free_columns(graph, &matching);

        let mut parts = Self::default();
        for (row, &over) in is_over.iter().enumerate() {
            match matching.column_of()[row] {
                _ if over => parts.over.rows.push(row),
                Some(column) if is_under[column] => parts.under.rows.push(row),
                _ => {}
            }
        }
        for (column, &under) in is_under.iter().enumerate() {
            match matching.row_of()[column] {
                _ if under => parts.under.columns.push(column),
                Some(row) if is_over[row] => parts.over.columns.push(column),
                _ => {}
            }
        }
        parts.just = blocks(graph, &matching, &|row| {
            let column = matching.column_of()[row]?;
            (!is_over[row] && !is_under[column]).then_some(column)
        });
        parts
    }

    /// Redundancy of the overdetermined part: its equations less its unknowns.
    #[must_use]
    pub fn redundancy(&self) -> usize {
        self.over.rows.len().saturating_sub(self.over.columns.len())
    }
}

fn reach_from_free_columns(graph: &Graph, matching: &Matching) -> Vec<bool> {
    let transposed = graph.transposed();
    let mut reached: Vec<bool> = matching.row_of().iter().map(Option::is_none).collect();
    let mut waiting: Vec<usize> = (0..reached.len()).filter(|&column| reached[column]).collect();
    while let Some(column) = waiting.pop() {
        let rows = transposed.rows()[column].iter();
        for other in rows.filter_map(|&row| matching.column_of()[row]) {
            if !std::mem::replace(&mut reached[other], true) {
                waiting.push(other);
            }
        }
    }
    reached
}

/// Blocks of the rows for which `column_of` answers, each after those whose columns it needs.
fn blocks(
    graph: &Graph,
    matching: &Matching,
    column_of: &dyn Fn(usize) -> Option<usize>,
) -> Vec<Part> {
    let just: Vec<usize> = (0..graph.rows().len()).filter(|&r| column_of(r).is_some()).collect();
    let mut place = vec![None; graph.rows().len()];
    for (index, &row) in just.iter().enumerate() {
        place[row] = Some(index);
    }
    let needs = |&row: &usize| {
        let others = graph.rows()[row].iter().filter_map(|&column| matching.row_of()[column]);
        others.filter_map(|other| place[other]).collect()
    };
    let needed: Vec<Vec<usize>> = just.iter().map(needs).collect();
    let part = |component: Vec<usize>| {
        let rows: Vec<usize> = component.into_iter().map(|index| just[index]).collect();
        let mut columns: Vec<usize> = rows.iter().filter_map(|&row| column_of(row)).collect();
        columns.sort_unstable();
        Part { rows, columns }
    };
    components(&needed).into_iter().map(part).collect()
}
