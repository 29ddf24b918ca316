//! Minimal sets of equations that can be tested against each other.
//!
//! | set | what it is | paper |
//! |---|---|---|
//! | MSO | minimal structurally overdetermined set: one equation more than unknowns, and no part of it is overdetermined. One residual each. | Krysander, Åslund and Nyberg 2008 |
//! | TES | test equation support: all equations that may be used in a test which is to react to certain faults and to no others | Krysander, Åslund and Frisk 2010 |
//! | MTES | a TES of which no part reacts to any fault without reacting to all of the same: the sharpest tests there are | the same |
//!
//! # When not to use it
//!
//! The number of MSO sets grows exponentially with the redundancy of a model, that of MTES with the number
//! of faults. To learn which faults can be detected and isolated at all, no set is needed: see
//! [`analysis`](crate::analysis). To choose tests, MTES are far fewer and isolate as well as
//! all MSO sets do; an MSO set within one of them is then made into a residual.

mod lumped;
mod mso;
mod mtes;

use serde::Serialize;

pub use self::mtes::Supports;
use crate::model::EquationSet;

/// How many nodes of a search are visited per set that is asked for, and at least: searches have blind ends.
const NODES_PER_SET: usize = 20;
/// See [`NODES_PER_SET`].
const LEAST_NODES: usize = 10_000;

/// Sets of equations that a search has found, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Family {
    /// The sets.
    pub sets: Vec<EquationSet>,
    /// Whether these are all; otherwise there are more than were asked for.
    pub is_complete: bool,
}

/// What a search may still do.
struct Search {
    family: Family,
    most: usize,
    nodes: usize,
}

impl Search {
    fn new(most: usize) -> Self {
        let nodes = most.saturating_mul(NODES_PER_SET).max(LEAST_NODES);
        Self { family: Family { sets: Vec::new(), is_complete: true }, most, nodes }
    }

    /// Whether another node may be visited.
    fn goes_on(&mut self) -> bool {
        self.family.is_complete &= 0 < self.nodes;
        self.nodes = self.nodes.saturating_sub(1);
        self.family.is_complete
    }

    fn found(&mut self, set: EquationSet) {
        if self.family.sets.len() < self.most {
            self.family.sets.push(set);
        } else {
            self.family.is_complete = false;
        }
    }

    fn finish(self) -> Family {
        let mut family = self.family;
        family.sets.sort_unstable();
        family
    }
}
