//! Effects that are fitted together: sets of them, and what can be added to one.
//!
//! A set is one fit with the parameters of all its members beside those of the model. What is sought beside a set is screened
//! against what the set leaves, with its parameters among the nuisances, and fitted with all of them.

mod beside;
mod search;
mod set;

pub(crate) use self::search::Round;
pub use self::{beside::Wanted, search::SetSearch, set::EffectSet};
pub(super) use self::{
    beside::{beside, to_come_near},
    set::{Member, is_there},
};
