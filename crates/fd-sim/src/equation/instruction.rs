//! An instruction of the bytecode.

use super::expr::{Binary, Comparison, Lookup, Unary};

#[derive(Clone, Copy, Debug)]
pub(super) struct Instruction {
    pub operation: Operation,
    pub to: u32,
    pub a: u32,
    pub b: u32,
    pub c: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Operation {
    // The four that make up most programs have a place of their own in the jump table.
    Add,
    Sub,
    Mul,
    Div,
    /// Slot `a` times slot `b`, plus slot `c`; rounded in between, as are the next two.
    MulAdd,
    /// Slot `a` times slot `b`, less slot `c`.
    MulSub,
    /// Slot `c` less slot `a` times slot `b`.
    SubMul,
    Unary(Unary),
    Binary(Binary),
    /// Slot `a` to a literal power.
    Power(i32),
    Clamp,
    Compare(Comparison),
    And,
    Or,
    Not,
    /// Slot `b` if slot `a` holds 1, else slot `c`.
    Select,
    /// Table number `b` at slot `a`.
    Lookup(Lookup),
}
