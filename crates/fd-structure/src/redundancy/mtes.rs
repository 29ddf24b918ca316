//! Test equation supports.

use serde::Serialize;

use super::{Family, Search, lumped::Lumped};
use crate::model::StructuralModel;

/// Which test equation supports are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Supports {
    /// The minimal ones.
    #[default]
    Minimal,
    /// All.
    All,
}

impl StructuralModel {
    /// Test equation supports, at most this many (Krysander, Åslund and Frisk 2010): classes of equations with
    /// faults are left out one after the other until all faults that are left are in one class.
    ///
    /// A model without detectable faults has none.
    ///
    /// ```
    /// use fd_structure::{model::StructuralModel, redundancy::Supports};
    ///
    /// let model = StructuralModel::builder("two sensors and a trusted one")
    ///     .equation("a", ["x"], ["y1"])
    ///     .equation("b", ["x"], ["y2"])
    ///     .equation("c", ["x"], ["y3"])
    ///     .fault("fa", "a")
    ///     .fault("fb", "b")
    ///     .build()?;
    /// assert_eq!(model.test_supports(Supports::Minimal, 10).sets, [[0, 2], [1, 2]]);
    /// assert_eq!(model.test_supports(Supports::All, 10).sets.len(), 3);
    /// # Ok::<(), fd_structure::model::StructureError>(())
    /// ```
    #[must_use]
    pub fn test_supports(&self, wanted: Supports, most: usize) -> Family {
        let mut search = Search::new(most);
        let all = Lumped::of(self);
        if 0 < all.redundancy() {
            visit(&all, wanted, &mut search);
        }
        search.finish()
    }
}

fn visit(node: &Lumped, wanted: Supports, search: &mut Search) {
    if !search.goes_on() {
        return;
    }
    let mut node = node.lump(|row| row.has_fault);
    let classes: Vec<usize> = (0..node.rows.len()).filter(|&i| node.rows[i].has_fault).collect();
    let is_minimal = classes.len() == 1;
    if is_minimal || (wanted == Supports::All && !classes.is_empty()) {
        search.found(node.equations());
    }
    if is_minimal {
        return;
    }
    for index in classes {
        if std::mem::replace(&mut node.rows[index].is_removable, false) {
            visit(&node.without(index), wanted, search);
        }
        if !search.family.is_complete {
            break;
        }
    }
}
