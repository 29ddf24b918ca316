//! The contract about memory that every stage fulfils besides its own trait.

use std::fmt::Debug;

use crate::{scalar::Scalar, visitor::StateVisitor};

/// A memory that can be restarted, saved and restored.
///
/// Every stage but [`Plant`](super::Plant) is a `Stage`: what it returns depends on the samples it has seen.
/// This trait is the contract about that memory, and about nothing else. The supertraits add that a stage can
/// be printed, moved to another thread and shared between threads.
///
/// # The contract
///
/// A stage has two kinds of fields. *Constants* are fixed when it is built: gains, thresholds,
/// orders. *Memory* is what samples change: states, sums, counters, flags, parameters learned on
/// line. Then
///
/// * [`reset`](Self::reset) restores the memory that the constructor set. A reset stage and a new one give
///   bit-identical results from then on.
/// * [`visit_state`](Self::visit_state) shows all of the memory to a visitor, always in the same order.
///   Restoring what it showed gives the same future, bit for bit.
///
/// That second sentence holds for phases and counters as well as for states. A detector that alarms
/// after three exceedances must show the number it has counted so far, or a restart at the wrong
/// moment costs an alarm.
///
/// # Who calls it, and when
///
/// [`Pipeline`](crate::Pipeline) is itself a stage and forwards both calls to its parts. `reset` is
/// called between runs: before a log is replayed, between resampled records of a calibration.
/// `visit_state` is called by [`Snapshot::of`](crate::Snapshot::of), which reads, and by
/// [`Snapshot::restore`](crate::Snapshot::restore), which first checks that names and lengths
/// agree and then writes. There is one list for both directions, so they cannot drift apart.
///
/// Neither is called per sample. Both may be slow, but neither allocates in the stage itself: sizes do not
/// change after construction.
///
/// # How to write `visit_state`
///
/// Pass whole slices where the memory is a slice. Other numbers go through a local array and back:
///
/// ```text
/// let mut counts = [self.seen, u64::from(self.is_open)];
/// visitor.counts("seen, open", &mut counts);
/// self.seen = counts[0];
/// self.is_open = counts[1] != 0;
/// ```
///
/// * Name what it is; names appear in [`SnapshotError`](crate::SnapshotError).
/// * The number of fields and their lengths must depend on constants only. Show a half-filled
///   window whole, with the number of valid entries beside it.
/// * A snapshot comes from a file. An index that was read back must be brought into range before it
///   is used (`counts[0] % window`), because a stage that panics on its memory breaks rule 2 of the
///   [module](super).
/// * Skip whatever can be derived from the rest, such as scratch buffers that each step overwrites. Skip
///   constants: a snapshot is restored into a stage of the same design, not instead of one.
///
/// # When not to implement it
///
/// A model without memory is a [`Plant`](super::Plant), whose state belongs to the caller. A stage
/// without memory (a norm against a constant threshold) implements both methods with empty bodies.
///
/// # Example
///
/// The mean of all samples so far, with its memory of one real and one counter:
///
/// ```
/// use fd_core::{Snapshot, StateVisitor, stage::Stage};
///
/// #[derive(Debug, Default)]
/// struct Mean {
///     mean: f64,
///     samples: u64,
/// }
///
/// impl Mean {
///     fn add(&mut self, value: f64) -> f64 {
///         self.samples += 1;
///         self.mean += (value - self.mean) / self.samples as f64;
///         self.mean
///     }
/// }
///
/// impl Stage for Mean {
///     fn reset(&mut self) {
///         *self = Self::default();
///     }
///
///     fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
///         visitor.reals("mean", std::slice::from_mut(&mut self.mean));
///         visitor.counts("samples of the mean", std::slice::from_mut(&mut self.samples));
///     }
/// }
///
/// let mut mean = Mean::default();
/// mean.add(1.0);
/// mean.add(2.0);
/// let saved = Snapshot::of(&mut mean);
/// assert_eq!(mean.add(6.0), 3.0);
///
/// // Another machine, another day: a new stage goes on where the old one was saved. Without the
/// // counter it would answer 6.
/// let mut restored = Mean::default();
/// saved.restore(&mut restored)?;
/// assert_eq!(restored.add(6.0), 3.0);
///
/// restored.reset();
/// assert_eq!(restored.add(6.0), 6.0);
/// # Ok::<(), fd_core::SnapshotError>(())
/// ```
pub trait Stage<T: Scalar = f64>: Debug + Send + Sync {
    /// Forgets all samples; the stage then behaves as when it was built.
    fn reset(&mut self);

    /// Shows every number that influences the future to `visitor`, always in the same order.
    ///
    /// Constants of the design (gains, thresholds) are not memory and are not visited.
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>);
}
