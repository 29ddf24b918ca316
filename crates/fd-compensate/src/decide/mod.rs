//! From test statistics to decisions.
//!
//! Rules are mute while the compensator trains: no threshold for `r*` applies to an innovation.
//!
//! | Rule | Says |
//! |------|------|
//! | [`Debounce`] | that there is a fault, and since when |
//! | [`SizedDebounce`] | the same, which of the known faults explains it best, and how large it is |

mod debounce;
mod error;
mod size;

pub use self::{
    debounce::{Debounce, Debouncing},
    error::RuleError,
    size::{Hypothesis, SizedDebounce, Sizing},
};
