//! The loop that runs bytecode.

use super::{
    evaluate,
    expr::{Binary, Unary},
    kernel::Kernel,
    program::{Instruction, Operation},
    table::Table,
    value::Value,
};

/// Runs instructions one after the other.
#[inline(always)]
pub(super) fn interpret<V: Value>(
    kernel: impl Kernel<V>,
    instructions: &[Instruction],
    tables: &[Table],
    slots: &mut [V],
) {
    for instruction in instructions {
        let a = slots[instruction.a as usize];
        let b = || slots[instruction.b as usize];
        let c = || slots[instruction.c as usize];
        let value = match instruction.operation {
            Operation::Add => kernel.add(a, b()),
            Operation::Sub => kernel.sub(a, b()),
            Operation::Mul | Operation::And => kernel.mul(a, b()),
            Operation::Div => kernel.div(a, b()),
            Operation::Unary(Unary::Neg) => kernel.neg(a),
            Operation::Unary(Unary::Sqrt) => kernel.sqrt(a),
            Operation::Unary(function) => a.map(|a| evaluate::unary(function, a)),
            Operation::Binary(Binary::Min) => kernel.smaller(a, b()),
            Operation::Binary(Binary::Max) => kernel.larger(a, b()),
            Operation::Binary(function) => a.zip(b(), |a, b| evaluate::binary(function, a, b)),
            Operation::Power(2) => kernel.mul(a, a),
            Operation::Power(exponent) => a.map(|a| evaluate::power(a, exponent)),
            Operation::Clamp => kernel.smaller(kernel.larger(a, b()), c()),
            Operation::Compare(comparison) => kernel.compare(comparison, a, b()),
            Operation::Or => kernel.larger(a, b()),
            Operation::Not => kernel.sub(V::constant(1.0), a),
            Operation::Select => kernel.select(a, b(), c()),
            Operation::Lookup(kind) => {
                let table = &tables[instruction.b as usize];
                a.map(|a| evaluate::lookup(kind, table, a))
            }
        };
        slots[instruction.to as usize] = value;
    }
}
