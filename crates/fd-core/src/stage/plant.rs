//! Models that can be stepped.

use std::fmt::Debug;

use crate::{dims::IoDims, scalar::Scalar};

/// A discrete-time system `x⁺ = f(x, u)`, `y = h(x, u)`.
///
/// A plant is a value without memory: the caller owns the state. One plant can therefore
/// serve an observer, a simulator and a finite-difference Jacobian at the same time.
///
/// A plant that leaves its region of validity (an engine in surge, a diverging integration)
/// writes NaN from then on; whoever drives it checks for that.
pub trait Plant<T: Scalar = f64>: Debug + Send + Sync {
    /// Number of states.
    fn nx(&self) -> usize;

    /// Numbers of inputs and outputs.
    fn io(&self) -> IoDims;

    /// Writes the next state.
    fn advance(&self, x: &[T], u: &[T], x_next: &mut [T]);

    /// Writes the output.
    fn output(&self, x: &[T], u: &[T], y: &mut [T]);
}
