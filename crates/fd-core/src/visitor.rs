//! Who walks over the memory of a stage.

/// Walks over the memory of a stage.
///
/// A stage hands out every number that influences its future, always in the same order. A
/// visitor may read or overwrite them. [`Snapshot`](crate::Snapshot) is made of three visitors: one that reads, one
/// that compares names and lengths, one that writes. Others are easily written:
///
/// ```
/// use fd_core::{StateVisitor, stage::Stage};
///
/// /// How many numbers a stage remembers.
/// #[derive(Default)]
/// struct Size(usize);
///
/// impl<T> StateVisitor<T> for Size {
///     fn reals(&mut self, _name: &'static str, values: &mut [T]) {
///         self.0 += values.len();
///     }
///
///     fn counts(&mut self, _name: &'static str, values: &mut [u64]) {
///         self.0 += values.len();
///     }
/// }
///
/// fn size(stage: &mut dyn Stage) -> usize {
///     let mut size = Size::default();
///     stage.visit_state(&mut size);
///     size.0
/// }
///
/// assert_eq!(size(&mut fd_core::stage::Uncompensated::new(3)), 0);
/// ```
pub trait StateVisitor<T> {
    /// Visits real numbers.
    fn reals(&mut self, name: &'static str, values: &mut [T]);

    /// Visits real numbers of which some are NaN where nothing is known yet, or nobody is.
    fn reals_with_holes(&mut self, name: &'static str, values: &mut [T]) {
        self.reals(name, values);
    }

    /// Visits counters, flags and other integers.
    fn counts(&mut self, name: &'static str, values: &mut [u64]);
}
