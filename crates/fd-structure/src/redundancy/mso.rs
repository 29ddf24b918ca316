//! Minimal structurally overdetermined sets.

use super::{Family, Search, lumped::Lumped};
use crate::model::StructuralModel;

impl StructuralModel {
    /// The minimal structurally overdetermined sets, at most this many (Krysander, Åslund and Nyberg 2008,
    /// algorithm 2): classes of equations are left out one after the other until there is one
    /// equation more than unknowns. No set is reached twice.
    ///
    /// ```
    /// use fd_structure::model::StructuralModel;
    ///
    /// // The same quantity measured three times.
    /// let model = StructuralModel::builder("three of a kind")
    ///     .equation("a", ["x"], ["y1"])
    ///     .equation("b", ["x"], ["y2"])
    ///     .equation("c", ["x"], ["y3"])
    ///     .build()?;
    /// let all = model.mso_sets(10);
    /// assert_eq!(all.sets, [[0, 1], [0, 2], [1, 2]]);
    /// assert!(all.is_complete && !model.mso_sets(2).is_complete);
    /// # Ok::<(), fd_structure::model::StructureError>(())
    /// ```
    #[must_use]
    pub fn mso_sets(&self, most: usize) -> Family {
        let mut search = Search::new(most);
        let all = Lumped::of(self);
        let redundancy = all.redundancy();
        if 0 < redundancy {
            visit(&all, redundancy, &mut search);
        }
        search.finish()
    }
}

fn visit(node: &Lumped, redundancy: usize, search: &mut Search) {
    if !search.goes_on() {
        return;
    }
    if redundancy == 1 {
        search.found(node.equations());
        return;
    }
    let mut node = node.lump(|row| row.is_removable);
    let removable: Vec<usize> =
        (0..node.rows.len()).filter(|&i| node.rows[i].is_removable).collect();
    for (tried, &index) in removable.iter().enumerate() {
        // Each level takes one class out, and there must be that many left.
        if removable.len() - tried < redundancy - 1 {
            break;
        }
        node.rows[index].is_removable = false;
        visit(&node.without(index), redundancy - 1, search);
        if !search.family.is_complete {
            break;
        }
    }
}
