//! What a slot of the bytecode holds, one number or several side by side, and what a program needs of a machine for it.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use std::fmt::Debug;

use fd_core::Scalar;

use super::expr::Comparison;

/// A number, or several independent ones that take the same way through a program.
///
/// Every [`Scalar`] is a value of one lane. [`Lanes`] has several: one pass through the
/// instructions then does the work of as many runs, and what it computes in each lane is to the
/// bit what a run of its own would.
///
/// ```
/// use fd_sim::equation::{Expr, Lanes, Program, Scope, Value};
///
/// /// The decay at a time, for any kind of numbers.
/// fn decay<V: Value>(program: &Program, t: V) -> V {
///     let mut workspace = program.workspace::<V>();
///     workspace.fast_mut()[0] = t;
///     let mut results = [V::constant(0.0)];
///     program.run(&mut workspace, &mut results);
///     results[0]
/// }
///
/// let scope = Scope { fast: vec!["t".into()], ..Scope::default() };
/// let program = Program::compile(&scope, &[Expr::parse("exp(-t/2)")?])?;
/// let side_by_side = decay(&program, Lanes([0.0, 1.0, 2.0, 3.0]));
/// for (lane, t) in [0.0_f64, 1.0, 2.0, 3.0].into_iter().enumerate() {
///     assert_eq!(side_by_side.lane(lane).to_bits(), decay(&program, t).to_bits());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Value: Copy + Debug + Send + Sync + 'static {
    /// One of the numbers.
    type Lane: Scalar;

    /// How many there are.
    const LANES: usize;

    /// The same number in every lane.
    fn splat(lane: Self::Lane) -> Self;

    /// The number in a lane.
    fn lane(&self, lane: usize) -> Self::Lane;

    /// Replaces the number in a lane.
    fn set_lane(&mut self, lane: usize, value: Self::Lane);

    /// A function of each lane.
    #[must_use]
    fn map(self, f: impl Fn(Self::Lane) -> Self::Lane) -> Self;

    /// A function of each lane of two values.
    #[must_use]
    fn zip(self, b: Self, f: impl Fn(Self::Lane, Self::Lane) -> Self::Lane) -> Self;

    /// A function of each lane of three values.
    #[must_use]
    fn zip3(
        self,
        b: Self,
        c: Self,
        f: impl Fn(Self::Lane, Self::Lane, Self::Lane) -> Self::Lane,
    ) -> Self;

    /// Whether all the numbers are finite.
    fn all_finite(&self) -> bool;

    /// Does some work, with the best instructions that this machine has for such values.
    fn vectorized<W: Work<Self>>(work: W);

    /// A constant in every lane.
    #[must_use]
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::splat(Self::Lane::from_design(value))
    }
}

/// `N` numbers side by side.
///
/// Arithmetic, roots, comparisons, sines and exponentials of all lanes are one or a few dozen
/// instructions where the machine has wide registers (AVX2, found at run time); the other functions
/// are called lane by lane.
///
/// ```
/// use fd_sim::equation::{Expr, Lanes, Program, Scope};
///
/// let scope = Scope { fast: vec!["x".into()], ..Scope::default() };
/// let program = Program::compile(&scope, &[Expr::parse("x^2 + 1")?])?;
/// let mut workspace = program.workspace::<Lanes<4>>();
/// workspace.fast_mut()[0] = Lanes([0.0, 1.0, 2.0, 3.0]);
/// let mut results = [Lanes([0.0; 4])];
/// program.run(&mut workspace, &mut results);
/// assert_eq!(results[0].0, [1.0, 2.0, 5.0, 10.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes<const N: usize>(pub [f64; N]);

/// The cheap operations on values, written to `to`. Each lane gets to the bit what `evaluate` says.
pub trait Kernel<V: Value>: Copy {
    /// `a + b`.
    fn add(self, to: &mut V, a: &V, b: &V);
    /// `a - b`.
    fn sub(self, to: &mut V, a: &V, b: &V);
    /// `a*b`.
    fn mul(self, to: &mut V, a: &V, b: &V);
    /// `a/b`.
    fn div(self, to: &mut V, a: &V, b: &V);
    /// `a*b + c`, with the product rounded.
    fn mul_add(self, to: &mut V, a: &V, b: &V, c: &V);
    /// `a*b - c`, with the product rounded.
    fn mul_sub(self, to: &mut V, a: &V, b: &V, c: &V);
    /// `c - a*b`, with the product rounded.
    fn sub_mul(self, to: &mut V, a: &V, b: &V, c: &V);
    /// `-a`.
    fn neg(self, to: &mut V, a: &V);
    /// `sqrt(a)`.
    fn sqrt(self, to: &mut V, a: &V);
    /// `sin(a)`.
    fn sin(self, to: &mut V, a: &V);
    /// `cos(a)`.
    fn cos(self, to: &mut V, a: &V);
    /// `exp(a)`.
    fn exp(self, to: &mut V, a: &V);
    /// `tanh(a)`.
    fn tanh(self, to: &mut V, a: &V);
    /// `b` where `b < a`, else `a`.
    fn smaller(self, to: &mut V, a: &V, b: &V);
    /// `b` where `a < b`, else `a`.
    fn larger(self, to: &mut V, a: &V, b: &V);
    /// `a` within `b` and `c`.
    fn clamp(self, to: &mut V, a: &V, b: &V, c: &V);
    /// 1 where the comparison holds, else 0.
    fn compare(self, comparison: Comparison, to: &mut V, a: &V, b: &V);
    /// `b` where `0 < a`, else `c`.
    fn select(self, to: &mut V, a: &V, b: &V, c: &V);
}

/// Something to be computed with a kernel.
pub trait Work<V: Value> {
    /// Computes it.
    fn run(self, kernel: impl Kernel<V>);
}
