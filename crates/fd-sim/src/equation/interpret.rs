//! The loop that runs bytecode.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use super::{
    evaluate,
    expr::{Binary, Unary},
    instruction::{Instruction, Operation},
    table::Table,
    value::{Kernel, Value},
};

/// Runs instructions one after the other.
#[inline(always)]
pub(super) fn interpret<V: Value>(
    kernel: impl Kernel<V>,
    instructions: &[Instruction],
    tables: &[Table],
    slots: &mut [V],
) {
    for &Instruction { operation, to, a, b, c } in instructions {
        // Operands come before the result.
        let (known, new) = slots.split_at_mut(to as usize);
        let to = &mut new[0];
        let slot = |number: u32| &known[number as usize];
        match operation {
            Operation::Add => kernel.add(to, slot(a), slot(b)),
            Operation::Sub => kernel.sub(to, slot(a), slot(b)),
            Operation::Mul | Operation::And => kernel.mul(to, slot(a), slot(b)),
            Operation::Div => kernel.div(to, slot(a), slot(b)),
            Operation::MulAdd => kernel.mul_add(to, slot(a), slot(b), slot(c)),
            Operation::MulSub => kernel.mul_sub(to, slot(a), slot(b), slot(c)),
            Operation::SubMul => kernel.sub_mul(to, slot(a), slot(b), slot(c)),
            Operation::Unary(Unary::Neg) => kernel.neg(to, slot(a)),
            Operation::Unary(Unary::Sqrt) => kernel.sqrt(to, slot(a)),
            Operation::Unary(Unary::Sin) => kernel.sin(to, slot(a)),
            Operation::Unary(Unary::Cos) => kernel.cos(to, slot(a)),
            Operation::Unary(Unary::Exp) => kernel.exp(to, slot(a)),
            Operation::Unary(Unary::Tanh) => kernel.tanh(to, slot(a)),
            Operation::Unary(function) => *to = unary(function, *slot(a)),
            Operation::Binary(Binary::Min) => kernel.smaller(to, slot(a), slot(b)),
            Operation::Or | Operation::Binary(Binary::Max) => kernel.larger(to, slot(a), slot(b)),
            Operation::Binary(function) => {
                *to = slot(a).zip(*slot(b), |a, b| evaluate::binary(function, a, b));
            }
            Operation::Power(2) => kernel.mul(to, slot(a), slot(a)),
            Operation::Power(exponent) => *to = slot(a).map(|a| evaluate::power(a, exponent)),
            Operation::Clamp => kernel.clamp(to, slot(a), slot(b), slot(c)),
            Operation::Compare(comparison) => kernel.compare(comparison, to, slot(a), slot(b)),
            Operation::Not => kernel.sub(to, &V::constant(1.0), slot(a)),
            Operation::Select => kernel.select(to, slot(a), slot(b), slot(c)),
            Operation::Lookup(kind) => {
                let table = &tables[b as usize];
                *to = slot(a).map(|a| evaluate::lookup(kind, table, a));
            }
        }
    }
}

/// A function of each lane, chosen before the loop over the lanes.
#[inline(always)]
fn unary<V: Value>(function: Unary, a: V) -> V {
    macro_rules! choose {
        ($($known:ident)*) => {
            match function {
                $(Unary::$known => a.map(|a| evaluate::unary(Unary::$known, a)),)*
                other => a.map(|a| evaluate::unary(other, a)),
            }
        };
    }
    choose!(Abs Sign Step)
}
