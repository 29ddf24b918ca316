//! From samples to residuals.

use crate::{dims::IoDims, frame::Frame, scalar::Scalar, stage::Stage};

/// A signal that is near zero while the plant behaves as modelled.
///
/// This is the first stage of every diagnosis. It takes the inputs `u` and the outputs `y` of the plant and
/// writes what the model cannot explain: the *primary residual* `r`. Every linear generator has the form
/// `r = H_u u + H_y y` with `H_u + H_y G_u = 0` (Patton and Chen 1992, eq. 2 and 5), so that the input does not
/// reach the residual of a plant that equals its model.
///
/// # The contract
///
/// * [`step`](Self::step) is called once per sample, in the order of time, with a frame of
///   [`io`](Self::io) channels, and writes all [`residual_len`](Self::residual_len) channels of `r`.
/// * `r` depends on this frame and on earlier ones, never on later ones. It is not normalised: its unit depends
///   on the method and is usually that of the outputs. Scaling is the task of the detector, which learns it
///   from healthy data.
/// * A fault must reach `r`, and noise may. Modelling errors reach it too; subtracting their bias is the task
///   of the [`Compensator`](super::Compensator), not of the generator.
/// * A generator that is not ready yet (a window that is filling, an observer that is converging) writes zero,
///   or its transient. It does not signal "not ready". Training skips the first samples (`settle_s` in a spec).
///
/// # Who calls it, and when
///
/// [`Pipeline::step`](crate::Pipeline::step), first of the four stages. In addition, training runs the
/// generator alone over healthy logs, and a bank steps several generators with the same frame.
///
/// A sample that the pipeline rejects never arrives: for the generator, the next good one follows
/// the last good one immediately. A sample that the pipeline *holds* arrives like any other. A
/// generator therefore contains no code for missing samples, and `frame.k()` is a label, not a
/// clock.
///
/// # What an implementor must not do
///
/// * *Allocate or fail in `step`.* Window lengths and state sizes are known when it is built.
/// * *Use past decisions.* No information flows back from the later stages. An observer that stops correcting
///   during an alarm would be two stages in one.
/// * *Hide memory from [`visit_state`](super::Stage::visit_state).* The state estimate, the window,
///   the number of samples still missing in it: all of it is memory.
/// * *Hide a NaN.* A plant model that left its region of validity makes the residual NaN. Pass it on.
///
/// # How it composes
///
/// As a type in [`Stages`](crate::Stages), as `Box<dyn ResidualGenerator>`, or by its `kind` in a
/// spec. Generators also contain generators: `fd_residual::weighted` multiplies the residual of any
/// other by a matrix, `fd_residual::bank` puts several side by side. Both are generators again.
///
/// # When not to implement it
///
/// For a linear method, write a `GeneratorDesign` (`fd-residual`) instead. Its `form()` gives you analysis
/// (which faults it detects, how far above the noise), its `build()` can return the ready-made generator of
/// that form, and you write no run-time code at all. Implement this trait directly for methods that are
/// nonlinear, adaptive, or faster in a special form.
///
/// # Example
///
/// A Luenberger observer of `x⁺ = a x + b u`, `y = x`, in any scalar. Its residual is the innovation `y − x̂`,
/// which forgets the unknown initial state by the factor `a − l` per sample:
///
/// ```
/// use fd_core::{Frame, IoDims, Scalar, StateVisitor, stage::{ResidualGenerator, Stage}};
///
/// #[derive(Clone, Debug)]
/// struct Innovation<T> {
///     a: T,
///     b: T,
///     l: T,
///     x: T,
/// }
///
/// impl<T: Scalar> Stage<T> for Innovation<T> {
///     fn reset(&mut self) {
///         self.x = T::zero();
///     }
///
///     fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
///         visitor.reals("estimated state", std::slice::from_mut(&mut self.x));
///     }
/// }
///
/// impl<T: Scalar> ResidualGenerator<T> for Innovation<T> {
///     fn io(&self) -> IoDims {
///         IoDims { nu: 1, ny: 1 }
///     }
///
///     fn residual_len(&self) -> usize {
///         1
///     }
///
///     fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
///         r[0] = frame.y()[0] - self.x;
///         self.x = self.a * self.x + self.b * frame.u()[0] + self.l * r[0];
///     }
/// }
///
/// // Chosen at run time it is the same generator.
/// let observer = Innovation { a: 0.9, b: 0.1, l: 0.5, x: 0.0 };
/// let mut observer: Box<dyn ResidualGenerator> = Box::new(observer);
///
/// // A plant that starts elsewhere; from sample 50 on its sensor reads 0.2 too much.
/// let (mut x, mut r) = (3.0, [0.0]);
/// for k in 0..100_u32 {
///     let u = [f64::from(k % 7)];
///     let y = [if k < 50 { x } else { x + 0.2 }];
///     observer.step(Frame::new(observer.io(), k.into(), &u, &y)?, &mut r);
///     if k == 49 {
///         // The start is forgotten: 3 · 0.4⁴⁹ is far below the rounding of x.
///         assert!(r[0].abs() < 1e-12, "healthy: {}", r[0]);
///     }
///     x = 0.9 * x + 0.1 * u[0];
/// }
/// // The fault stays visible, less what the correction follows: (1 − a) / (1 − a + l) of it.
/// assert!((r[0] - 0.2 * 0.1 / 0.6).abs() < 1e-12);
/// # Ok::<(), fd_core::FrameError>(())
/// ```
pub trait ResidualGenerator<T: Scalar = f64>: Stage<T> {
    /// Channels of the frames this generator accepts.
    fn io(&self) -> IoDims;

    /// Number of residual channels.
    fn residual_len(&self) -> usize;

    /// Consumes one sample and writes the residual into `r`.
    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]);
}
