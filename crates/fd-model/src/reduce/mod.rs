//! Model reduction: a model of few states in place of one of many.
//!
//! | method | keeps exactly | error `‖G − G_r‖∞` | here |
//! |--------|---------------|--------------------|------|
//! | balanced truncation | gain at `s = ∞` (continuous) | at most twice the sum of the discarded Hankel values | [`balanced_truncation`] |
//! | balanced residualisation | steady-state gain | the same | [`balanced_residualisation`] |
//! | residualisation onto chosen states | steady-state gain, meaning of the states | no bound | [`residualise_onto`] |
//!
//! Sources: B. C. Moore, "Principal component analysis in linear systems", IEEE TAC 26(1), 1981;
//! square-root balancing: A. J. Laub, M. T. Heath, C. C. Paige and R. C. Ward, IEEE TAC 32(2),
//! 1987; bound: K. Glover, Int. J. Control 39(6), 1984 (continuous), U. M. Al-Saggaf and
//! G. F. Franklin, ACC 1987 (discrete); residualisation: Y. Liu and B. D. O. Anderson, Int. J.
//! Control 50(4), 1989.
//!
//! Balanced methods need a stable model and depend on the units of inputs and outputs: scale per
//! unit first, or the outputs with the largest numbers win. Do not reduce a model whose fast part
//! is the point, such as actuator resonances above the bandwidth of the residual.

mod balancing;
mod residualisation;

use crate::{domain::TimeDomain, error::ModelError, state_space::StateSpace};

pub use self::residualisation::residualise_onto;
use self::{balancing::balanced_part, residualisation::residualise};

/// A reduced model and what is known about it.
#[derive(Clone, Debug)]
pub struct Reduction<D> {
    /// Reduced model.
    pub model: StateSpace<D>,
    /// Hankel singular values of the full model, largest first.
    pub hankel: Vec<f64>,
    /// Upper bound of `‖G − G_r‖∞`: twice the sum of the discarded Hankel values.
    pub error_bound: f64,
}

/// Keeps the `order` balanced states with the largest Hankel values and drops the others.
///
/// # Errors
///
/// Returns an error when the model is unstable, or has fewer than `order` states that are both
/// controllable and observable to working precision.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace, reduce};
///
/// // A slow lag and a fast one of small gain beside it.
/// let a = mat![[-1.0, 0.0], [0.0, -100.0]];
/// let plant = StateSpace::new(a, mat![[1.0], [1.0]], mat![[1.0, 1.0]], mat![[0.0]], Continuous)?;
/// let reduction = reduce::balanced_truncation(&plant, 1)?;
/// assert_eq!(reduction.model.nx(), 1);
/// assert!(reduction.error_bound < 0.011);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
pub fn balanced_truncation<D: TimeDomain>(
    model: &StateSpace<D>,
    order: usize,
) -> Result<Reduction<D>, ModelError> {
    let balanced = balanced_part(model, order, order)?;
    finish(balanced.model, balanced.hankel, order)
}

/// Balances, then takes the states beyond the first `order` as being in steady state (singular
/// perturbation), so that the steady-state gain stays exact.
///
/// # Errors
///
/// Returns an error when the model is unstable, or has fewer than `order` states that are both
/// controllable and observable to working precision.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace, reduce};
///
/// let a = mat![[-1.0, 0.0], [0.0, -100.0]];
/// let plant = StateSpace::new(a, mat![[1.0], [1.0]], mat![[1.0, 1.0]], mat![[0.0]], Continuous)?;
/// let reduction = reduce::balanced_residualisation(&plant, 1)?;
/// assert!((reduction.model.dc_gain()?[(0, 0)] - 1.01).abs() < 1e-14);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
pub fn balanced_residualisation<D: TimeDomain>(
    model: &StateSpace<D>,
    order: usize,
) -> Result<Reduction<D>, ModelError> {
    let balanced = balanced_part(model, order, model.nx())?;
    let reduced = residualise(&balanced.model, order, &model.dc_gain()?)?;
    finish(reduced, balanced.hankel, order)
}

/// Checks that a balanced method kept its promise of stability, which it does unless two Hankel
/// values agree across the cut.
fn finish<D: TimeDomain>(
    model: StateSpace<D>,
    hankel: Vec<f64>,
    order: usize,
) -> Result<Reduction<D>, ModelError> {
    model.stable_poles("the reduced model")?;
    let error_bound = 2.0 * hankel[order..].iter().sum::<f64>();
    Ok(Reduction { model, hankel, error_bound })
}
