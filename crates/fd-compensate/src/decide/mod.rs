//! From test statistics to decisions.
//!
//! Rules are mute while the compensator trains: no threshold for `r*` applies to an innovation.
//!
//! | Rule | Says |
//! |------|------|
//! | [`Debounce`] | that there is a fault, and since when |
//! | [`SizedDebounce`] | the same, which of the known faults explains it best, and how large it is |
//! | [`IsolatingDebounce`] | the same, with the probability of each known fault, of an unknown one and of none, and an interval of the size |

mod debounce;
mod error;
pub mod isolate;
mod mean;
mod size;

pub use self::{
    debounce::{Debounce, Debouncing},
    error::RuleError,
    isolate::{Candidate, Effect, FaultFree, IsolatingDebounce, Isolation},
    size::{Hypothesis, SizedDebounce, Sizing},
};
