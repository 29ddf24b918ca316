//! The faults that a residual reacts to.

use std::fmt;

/// The faults that a residual reacts to, printed as `1101`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Signature(pub Vec<bool>);

impl fmt::Display for Signature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|&bit| write!(f, "{}", u8::from(bit)))
    }
}
