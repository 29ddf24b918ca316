//! Bipartite graphs of equations (rows) and unknowns (columns): matchings, components, decomposition.
//!
//! Graph crates have parts of this for general graphs; here the alternating walks of a matching are
//! wanted by themselves, thousands of times on small graphs, so matching and components are a
//! page of code each on one plain representation.

mod components;
mod decomposition;
mod matching;

pub use self::{
    decomposition::{Decomposition, Part},
    matching::Matching,
};

/// Which columns occur in each row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Graph {
    rows: Vec<Vec<usize>>,
    columns: usize,
}

impl Graph {
    /// A graph with these columns in each row. There are at least as many columns as are named.
    ///
    /// ```
    /// use fd_structure::graph::Graph;
    ///
    /// let graph = Graph::new([vec![1, 0, 1], vec![2]], 2);
    /// assert_eq!((graph.rows()[0].as_slice(), graph.columns()), (&[0, 1][..], 3));
    /// ```
    #[must_use]
    pub fn new(rows: impl IntoIterator<Item = Vec<usize>>, columns: usize) -> Self {
        let mut rows: Vec<Vec<usize>> = rows.into_iter().collect();
        for row in &mut rows {
            row.sort_unstable();
            row.dedup();
        }
        let named = rows.iter().filter_map(|row| row.last()).max().map_or(0, |last| last + 1);
        Self { rows, columns: columns.max(named) }
    }

    /// The columns of each row, in order.
    #[must_use]
    pub fn rows(&self) -> &[Vec<usize>] {
        &self.rows
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Whether a column occurs in a row.
    #[must_use]
    pub fn has(&self, row: usize, column: usize) -> bool {
        self.rows.get(row).is_some_and(|row| row.binary_search(&column).is_ok())
    }

    /// The rows of each column, in order.
    pub(crate) fn transposed(&self) -> Self {
        let mut rows = vec![Vec::new(); self.columns];
        for (row, columns) in self.rows.iter().enumerate() {
            for &column in columns {
                rows[column].push(row);
            }
        }
        Self { rows, columns: self.rows.len() }
    }
}
