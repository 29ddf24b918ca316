//! From test statistics to decisions.
//!
//! Rules are mute while the compensator trains: no threshold for `r*` applies to an innovation.

mod debounce;
mod error;

pub use self::{
    debounce::{Debounce, Debouncing},
    error::RuleError,
};
