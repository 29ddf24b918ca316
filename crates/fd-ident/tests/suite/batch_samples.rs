//! A block of samples holds what was written into it, in whatever way, and nothing else.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::noise;
use fd_core::Snapshot;
use fd_ident::{
    batch::{BatchRls, SampleBlock},
    rls::{Forgetting, Guard, RlsDesign},
};

/// Sample by sample, or row by row and some of it removed again: what is learned is the same to the bit.
#[test]
fn a_block_is_the_same_however_it_is_written() {
    // Two tiles and a part of a third; every 13th sample is missing.
    let (n, count, steps) = (3, 21, 40);
    let numbers = noise(4, count * steps * (n + 1));
    let sample = |unit: usize, step: usize| &numbers[(unit * steps + step) * (n + 1)..][..=n];
    let is_missing = |unit: usize, step: usize| (step + unit) % 13 == 5;

    let mut single = SampleBlock::new(n, count, steps);
    let mut rows = SampleBlock::new(n, count, 2);
    rows.set_all(1, &vec![1.0; n * count], &vec![1.0; count]);
    rows.restart(steps);
    for step in 0..steps {
        let (mut phi, mut targets) = (vec![0.0; n * count], vec![0.0; count]);
        for unit in 0..count {
            let sample = sample(unit, step);
            (0..n).for_each(|i| phi[i * count + unit] = sample[i]);
            targets[unit] = sample[n];
            if !is_missing(unit, step) {
                single.set(unit, step, &sample[..n], sample[n]);
            }
        }
        rows.set_all(step, &phi, &targets);
    }
    for unit in 0..count {
        (0..steps).filter(|&step| is_missing(unit, step)).for_each(|step| rows.remove(unit, step));
    }
    let design = RlsDesign::forgetting(Forgetting::Exponential { lambda: 0.9 });
    let mut one = BatchRls::<f64>::new(n, count, &design).unwrap();
    let mut two = one.clone();
    one.update(&single).unwrap();
    two.update(&rows).unwrap();
    assert_eq!(Snapshot::of(&mut one), Snapshot::of(&mut two));
    assert!((0..count).all(|unit| one.guard(unit).skipped >= 3));
}

/// Nothing is forgotten for a sample that was never written, even without a guard.
#[test]
fn samples_of_a_new_block_are_missing() {
    let forgetting = Forgetting::Exponential { lambda: 0.9 };
    let design = RlsDesign { guard: Guard::off(), ..RlsDesign::forgetting(forgetting) };
    let mut batch = BatchRls::<f64>::new(2, 11, &design).unwrap();
    let (mut block, mut before, mut after) = (SampleBlock::new(2, 11, 5), [0.0; 2], [0.0; 2]);
    batch.variance_into(10, &mut before);
    for refilled in [false, true] {
        if refilled {
            (0..5).for_each(|step| block.set(10, step, &[1.0, 2.0], 3.0));
            block.restart(5);
        }
        batch.update(&block).unwrap();
        batch.variance_into(10, &mut after);
        assert_eq!(before.map(f64::to_bits), after.map(f64::to_bits));
    }
    assert_eq!(batch.guard(10).skipped, 10);
}
