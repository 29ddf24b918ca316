//! A product and the sum it goes into, as one instruction.

use std::collections::{HashMap, HashSet};

use super::{
    instruction::Operation,
    place::{Key, Place},
};

/// Puts products that are used once, by a sum or difference, into that instruction. The product is
/// still rounded before it is added: what is saved is the way through the slots.
pub(super) fn fuse(instructions: Vec<(Key, Place)>, results: &[Place]) -> Vec<(Key, Place)> {
    let mut uses: HashMap<Place, usize> = HashMap::new();
    let operands = instructions.iter().flat_map(|((_, operands), _)| operands);
    for place in operands.chain(results) {
        *uses.entry(*place).or_default() += 1;
    }
    let mut products: HashMap<Place, [Place; 2]> = HashMap::new();
    let mut dropped: HashSet<Place> = HashSet::new();
    let mut kept: Vec<(Key, Place)> = Vec::with_capacity(instructions.len());
    for ((operation, operands), to) in instructions {
        let [a, b, _] = operands;
        // A product of slow inputs stays where it is computed once.
        if operation == Operation::Mul && uses.get(&to) == Some(&1) && !to.is_slow() {
            products.insert(to, [a, b]);
        }
        let fused = match operation {
            Operation::Add => None
                .or_else(|| products.get(&a).map(|product| (Operation::MulAdd, *product, b, a)))
                .or_else(|| products.get(&b).map(|product| (Operation::MulAdd, *product, a, b))),
            Operation::Sub => None
                .or_else(|| products.get(&a).map(|product| (Operation::MulSub, *product, b, a)))
                .or_else(|| products.get(&b).map(|product| (Operation::SubMul, *product, a, b))),
            _ => None,
        };
        let Some((operation, [x, y], other, product)) = fused else {
            kept.push(((operation, operands), to));
            continue;
        };
        products.remove(&product);
        dropped.insert(product);
        kept.push(((operation, [x, y, other]), to));
    }
    kept.retain(|(_, to)| !dropped.contains(to));
    kept
}
