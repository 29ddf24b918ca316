//! Maximum matchings: as many rows as possible, each with a column of its own.

use std::collections::VecDeque;

use super::Graph;

/// No layer yet.
const UNREACHED: usize = usize::MAX;

/// Pairs of a row and a column that occurs in it; no row and no column is in two pairs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Matching {
    column_of: Vec<Option<usize>>,
    row_of: Vec<Option<usize>>,
}

impl Matching {
    /// A maximum matching, by Hopcroft and Karp (1973): shortest augmenting paths, all of one length at
    /// a time, hence of the order of `edges·√rows` steps.
    ///
    /// ```
    /// use fd_structure::graph::{Graph, Matching};
    ///
    /// let graph = Graph::new([vec![0], vec![0, 1], vec![1]], 2);
    /// assert_eq!(Matching::maximum(&graph).size(), 2);
    /// ```
    #[must_use]
    pub fn maximum(graph: &Graph) -> Self {
        let mut matching =
            Self { column_of: vec![None; graph.rows().len()], row_of: vec![None; graph.columns()] };
        while let Some(mut layers) = matching.layers(graph) {
            let mut next = vec![0; graph.rows().len()];
            for row in 0..graph.rows().len() {
                if matching.column_of[row].is_none() {
                    matching.augment(graph, row, &mut layers, &mut next);
                }
            }
        }
        matching
    }

    /// The column of each row.
    #[must_use]
    pub fn column_of(&self) -> &[Option<usize>] {
        &self.column_of
    }

    /// The row of each column.
    #[must_use]
    pub fn row_of(&self) -> &[Option<usize>] {
        &self.row_of
    }

    /// Number of pairs: the structural rank of the graph.
    #[must_use]
    pub fn size(&self) -> usize {
        self.column_of.iter().flatten().count()
    }

    /// Rows without a column.
    pub(crate) fn free_rows(&self) -> Vec<usize> {
        let rows = self.column_of.iter().enumerate();
        rows.filter(|(_, column)| column.is_none()).map(|(row, _)| row).collect()
    }

    /// Rows that alternating walks reach from these rows: along any column to the row that has it.
    pub(crate) fn reach(&self, graph: &Graph, from: impl IntoIterator<Item = usize>) -> Vec<bool> {
        let mut reached = vec![false; graph.rows().len()];
        let mut waiting: Vec<usize> = from.into_iter().collect();
        for &row in &waiting {
            reached[row] = true;
        }
        while let Some(row) = waiting.pop() {
            for other in graph.rows()[row].iter().filter_map(|&column| self.row_of[column]) {
                if !std::mem::replace(&mut reached[other], true) {
                    waiting.push(other);
                }
            }
        }
        reached
    }

    /// Takes a row out, and gives its column to another row if some alternating path allows it.
    pub(crate) fn remove_row(&mut self, graph: &Graph, row: usize) {
        let Some(lost) = self.column_of[row].take() else { return };
        self.row_of[lost] = None;
        // From free rows to the column, remembering how each row was reached.
        let mut waiting: Vec<usize> = self.free_rows();
        waiting.retain(|&free| free != row);
        let mut came_from: Vec<Option<usize>> = vec![None; graph.rows().len()];
        let mut seen = vec![false; graph.rows().len()];
        seen[row] = true;
        for &free in &waiting {
            seen[free] = true;
        }
        while let Some(at) = waiting.pop() {
            if graph.has(at, lost) {
                return self.give(lost, at, &came_from);
            }
            for other in graph.rows()[at].iter().filter_map(|&column| self.row_of[column]) {
                if !std::mem::replace(&mut seen[other], true) {
                    came_from[other] = Some(at);
                    waiting.push(other);
                }
            }
        }
    }

    /// Gives a column to a row, the column of that row to the one before it on the path, and so on.
    fn give(&mut self, column: usize, row: usize, came_from: &[Option<usize>]) {
        let (mut column, mut at) = (Some(column), Some(row));
        while let (Some(given), Some(row)) = (column, at) {
            column = self.column_of[row].replace(given);
            self.row_of[given] = Some(row);
            at = came_from[row];
        }
    }

    /// How many pairs lie between each row and a free row; `None` when no free column is reached.
    fn layers(&self, graph: &Graph) -> Option<Vec<usize>> {
        let mut layers = vec![UNREACHED; graph.rows().len()];
        let mut waiting: VecDeque<usize> = self.free_rows().into();
        for &row in &waiting {
            layers[row] = 0;
        }
        let mut is_augmentable = false;
        while let Some(row) = waiting.pop_front() {
            for &column in &graph.rows()[row] {
                match self.row_of[column] {
                    None => is_augmentable = true,
                    Some(other) if layers[other] == UNREACHED => {
                        layers[other] = layers[row] + 1;
                        waiting.push_back(other);
                    }
                    Some(_) => {}
                }
            }
        }
        is_augmentable.then_some(layers)
    }

    /// Looks for an augmenting path that goes up one layer at a time, and applies it.
    fn augment(&mut self, graph: &Graph, root: usize, layers: &mut [usize], next: &mut [usize]) {
        let mut rows = vec![root];
        // The column between each row of the path and the following one.
        let mut columns = Vec::new();
        while let Some(&row) = rows.last() {
            let Some(&column) = graph.rows()[row].get(next[row]) else {
                layers[row] = UNREACHED;
                rows.pop();
                columns.pop();
                continue;
            };
            next[row] += 1;
            match self.row_of[column] {
                None => {
                    columns.push(column);
                    for (&row, &column) in rows.iter().zip(&columns) {
                        self.column_of[row] = Some(column);
                        self.row_of[column] = Some(row);
                    }
                    return;
                }
                Some(other) if layers[other] == layers[row].saturating_add(1) => {
                    columns.push(column);
                    rows.push(other);
                }
                Some(_) => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_handed_on() {
        // Row 0 takes column 0 first; row 1 has nothing else.
        let graph = Graph::new([vec![0, 1], vec![0], vec![1, 2]], 3);
        let matching = Matching::maximum(&graph);
        assert_eq!(matching.column_of(), [Some(1), Some(0), Some(2)]);
    }

    #[test]
    fn a_lost_row_is_replaced() {
        let graph = Graph::new([vec![0], vec![0, 1], vec![1]], 2);
        let full = Matching::maximum(&graph);
        for row in 0..3 {
            let mut matching = full.clone();
            matching.remove_row(&graph, row);
            assert_eq!((matching.size(), matching.column_of()[row]), (2, None), "{row}");
        }
    }
}
