//! Laws that every implementation of a stage obeys, to be called from its tests.

use crate::{frame::Frame, scalar::Scalar, snapshot::Snapshot, stage::ResidualGenerator};

/// Samples `(u, y)` for a law.
pub type Samples<T> = [(Vec<T>, Vec<T>)];

/// Checks that a reset generator repeats itself exactly, and that one restored from a snapshot
/// taken half-way continues exactly as the original did.
///
/// # Panics
///
/// Panics when a law is broken.
pub fn reset_and_restore<T: Scalar>(
    generator: &mut (impl ResidualGenerator<T> + Clone),
    samples: &Samples<T>,
) {
    generator.reset();
    let mut fresh = generator.clone();
    let (first, second) = samples.split_at(samples.len() / 2);
    let start = run(generator, first);
    let snapshot = Snapshot::of(generator);
    let end = run(generator, second);

    generator.reset();
    assert_eq!(run(generator, first), start, "reset must restart the generator");
    assert!(snapshot.restore(&mut fresh).is_ok(), "a snapshot must fit its own generator");
    assert_eq!(run(&mut fresh, second), end, "a restored generator must continue as the original");
}

fn run<T: Scalar>(generator: &mut impl ResidualGenerator<T>, samples: &Samples<T>) -> Vec<T> {
    let io = generator.io();
    let mut r = vec![T::zero(); generator.residual_len()];
    let mut all = Vec::new();
    for (k, (u, y)) in (0..).zip(samples) {
        let frame = Frame::new(io, k, u, y);
        assert!(frame.is_ok(), "the law needs valid samples");
        if let Ok(frame) = frame {
            generator.step(frame, &mut r);
        }
        all.extend_from_slice(&r);
    }
    all
}
