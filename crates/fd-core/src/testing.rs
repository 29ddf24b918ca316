//! Laws that every implementation of a stage obeys, to be called from its tests.
//!
//! Only with the feature `testing`. Each crate of methods has a module of the same name with open
//! lists (`every_detector()`, `every_generator()`, …): a law is called on all of a list, so a new
//! method is put to it by one entry.

use std::fmt::Debug;

use crate::{
    frame::Frame,
    scalar::Scalar,
    snapshot::Snapshot,
    stage::{ResidualGenerator, Stage},
    visitor::StateVisitor,
};

/// One of a list: a name, and a stage behind it. `Named<dyn Detector>` is a detector of any kind.
pub type Named<S> = (&'static str, Box<S>);

/// Samples `(u, y)` for a law.
pub type Samples<T> = [(Vec<T>, Vec<T>)];

/// Checks the law of memory: a reset stage repeats itself exactly, a snapshot does not disturb it,
/// and a twin of the same design with another past, restored from that snapshot, continues exactly
/// as the original did, be it taken half-way or before the first sample.
///
/// `step` takes a stage through sample `k` of `samples` and returns all that can be seen of it.
///
/// ```
/// use fd_core::{StateVisitor, stage::{Detector, Stage, Verdict}, testing};
///
/// #[derive(Clone, Debug)]
/// struct Sum(f64);
///
/// impl Stage for Sum {
///     fn reset(&mut self) { self.0 = 0.0; }
///     fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
///         visitor.reals("sum", std::slice::from_mut(&mut self.0));
///     }
/// }
///
/// impl Detector for Sum {
///     fn residual_len(&self) -> usize { 1 }
///     fn update(&mut self, _u: &[f64], r: &[f64]) -> Verdict<f64> {
///         self.0 += r[0];
///         Verdict { statistic: self.0, threshold: 1.0 }
///     }
/// }
///
/// let r = [0.5, -0.25, 0.125, 1.0];
/// testing::memory(&mut Sum(0.0), &mut Sum(0.0), r.len(), |sum, k| sum.update(&[], &r[k..=k]));
/// ```
///
/// # Panics
///
/// Panics when the law is broken.
pub fn memory<T: Scalar, S: Stage<T>, R: PartialEq + Debug>(
    stage: &mut S,
    twin: &mut S,
    samples: usize,
    mut step: impl FnMut(&mut S, usize) -> R,
) {
    let cut = samples / 2;
    stage.reset();
    let unused = Snapshot::of(stage);
    let mut whole: Vec<R> = (0..cut).map(|k| step(stage, k)).collect();
    let snapshot = Snapshot::of(stage);
    whole.extend((cut..samples).map(|k| step(stage, k)));

    stage.reset();
    let again: Vec<R> = (0..samples).map(|k| step(stage, k)).collect();
    assert_eq!(again, whole, "reset must restart the stage, and a snapshot must not disturb it");

    for (snapshot, from) in [(snapshot, cut), (unused, 0)] {
        (0..samples).rev().for_each(|k| drop(step(twin, k)));
        let restored = snapshot.restore(twin);
        assert!(restored.is_ok(), "a snapshot must fit its own design: {restored:?}");
        let continued: Vec<R> = (from..samples).map(|k| step(twin, k)).collect();
        assert_eq!(continued, whole[from..], "a restored stage must continue as the original");
    }
}

/// Checks that no memory makes a stage panic: memories that no samples could have left (counters
/// anywhere, numbers beyond all sense) may give any results, and nothing of them is left after a reset.
///
/// `step` is as in [`memory`].
///
/// # Panics
///
/// Panics when the law is broken.
pub fn nonsense<T: Scalar, S: Stage<T>, R: PartialEq + Debug>(
    stage: &mut S,
    samples: usize,
    mut step: impl FnMut(&mut S, usize) -> R,
) {
    stage.reset();
    let whole: Vec<R> = (0..samples).map(|k| step(stage, k)).collect();
    for (real, count) in NONSENSE {
        stage.visit_state(&mut Overwrite { real: None, count: Some(count) });
        (0..samples).for_each(|k| drop(step(stage, k)));
        stage.visit_state(&mut Overwrite { real: Some(real), count: None });
        (0..samples).for_each(|k| drop(step(stage, k)));
    }
    stage.reset();
    let again: Vec<R> = (0..samples).map(|k| step(stage, k)).collect();
    assert_eq!(again, whole, "reset must restart the stage, whatever was in its memory");
}

/// Numbers and counters that snapshots let through.
const NONSENSE: [(f64, u64); 4] =
    [(1e300, 1 << 53), (f64::NEG_INFINITY, (1 << 53) - 1), (-1e-300, 7), (f64::INFINITY, 999_983)];

/// Puts the same number into all memory.
struct Overwrite {
    real: Option<f64>,
    count: Option<u64>,
}

impl<T: Scalar> StateVisitor<T> for Overwrite {
    fn reals(&mut self, _name: &'static str, values: &mut [T]) {
        if let Some(real) = self.real {
            values.fill(T::from_design(real));
        }
    }

    fn counts(&mut self, _name: &'static str, values: &mut [u64]) {
        if let Some(count) = self.count {
            values.fill(count);
        }
    }
}

/// Checks the law of [`memory`] on a residual generator.
///
/// # Panics
///
/// Panics when the law is broken.
pub fn reset_and_restore<T: Scalar>(
    generator: &mut (impl ResidualGenerator<T> + Clone),
    samples: &Samples<T>,
) {
    let mut twin = generator.clone();
    let mut r = vec![T::zero(); generator.residual_len()];
    memory(generator, &mut twin, samples.len(), |generator, k| {
        let (u, y) = &samples[k];
        let frame = Frame::new(generator.io(), k as u64, u, y);
        assert!(frame.is_ok(), "the law needs valid samples");
        if let Ok(frame) = frame {
            generator.step(frame, &mut r);
        }
        r.clone()
    });
}
