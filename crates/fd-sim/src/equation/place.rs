//! Where a value will be, while a program is compiled.

use super::instruction::Operation;

/// Where a value will be, before the number of constants is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Place {
    Slow(usize),
    Fast(usize),
    Constant(usize),
    /// Result of an instruction, and whether it depends on slow inputs alone.
    Result(usize, bool),
    /// No operand; or the number of a table.
    Other(usize),
}

impl Place {
    pub(super) fn is_slow(self) -> bool {
        !matches!(self, Self::Fast(_) | Self::Result(_, false))
    }
}

/// What an instruction does with what: two that are equal give the same.
pub(super) type Key = (Operation, [Place; 3]);
