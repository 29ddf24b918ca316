//! Residualisation: some states are taken to be in steady state at all times.

use faer::Mat;

use crate::{
    domain::TimeDomain,
    error::ModelError,
    linalg::{identity_minus, solve},
    state_space::StateSpace,
};

/// Keeps the chosen states with their meaning and units, and takes all others as being in steady
/// state.
///
/// The steady-state gain stays exact. There is no bound for the error elsewhere: look at
/// `full.difference(&reduced)?.hinf_norm(1e-3)?`. The result is unstable if the eliminated states
/// were needed for stability; check [`StateSpace::is_stable`].
///
/// # Errors
///
/// Returns an error when an index is out of range or occurs twice, or when the eliminated states
/// have no unique steady state.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace, reduce};
///
/// let a = mat![[-1.0, 1.0], [0.0, -100.0]];
/// let plant = StateSpace::new(a, mat![[0.0], [100.0]], mat![[1.0, 0.0]], mat![[0.0]], Continuous)?;
/// let slow = reduce::residualise_onto(&plant, &[0])?;
/// assert!((slow.a()[(0, 0)] + 1.0).abs() < 1e-15 && (slow.b()[(0, 0)] - 1.0).abs() < 1e-15);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
pub fn residualise_onto<D: TimeDomain>(
    model: &StateSpace<D>,
    states: &[usize],
) -> Result<StateSpace<D>, ModelError> {
    let n = model.nx();
    for (position, &index) in states.iter().enumerate() {
        if n <= index {
            return Err(ModelError::StateIndex { index, states: n, why: "does not exist" });
        }
        if states[..position].contains(&index) {
            return Err(ModelError::StateIndex { index, states: n, why: "is listed twice" });
        }
    }
    let others = (0..n).filter(|state| !states.contains(state));
    let order: Vec<usize> = states.iter().copied().chain(others).collect();
    let sorted = StateSpace::new(
        Mat::from_fn(n, n, |i, j| model.a()[(order[i], order[j])]),
        Mat::from_fn(n, model.nu(), |i, j| model.b()[(order[i], j)]),
        Mat::from_fn(model.ny(), n, |i, j| model.c()[(i, order[j])]),
        model.d().to_owned(),
        model.domain(),
    )?;
    eliminate(&sorted, states.len())
}

/// Keeps the first states and sets `D` such that the steady-state gain is `dc_gain` to rounding.
///
/// In exact arithmetic that is the `D` which the elimination gives; in floating point the weakly
/// coupled balanced states are known to few digits only, and this keeps them out of `D`.
pub(super) fn residualise<D: TimeDomain>(
    model: &StateSpace<D>,
    kept: usize,
    dc_gain: &Mat<f64>,
) -> Result<StateSpace<D>, ModelError> {
    let reduced = eliminate(model, kept)?;
    let d = reduced.d() + (dc_gain - reduced.dc_gain()?);
    let (a, b, c) = (reduced.a().to_owned(), reduced.b().to_owned(), reduced.c().to_owned());
    StateSpace::new(a, b, c, d, model.domain())
}

/// Puts the states after the first `kept` into steady state: with `σ = 0` or `1`,
/// `x₂ = (σI − A₂₂)⁻¹ (A₂₁ x₁ + B₂ u)`.
fn eliminate<D: TimeDomain>(
    model: &StateSpace<D>,
    kept: usize,
) -> Result<StateSpace<D>, ModelError> {
    let (rest, nu, ny) = (model.nx() - kept, model.nu(), model.ny());
    let steady =
        identity_minus(model.domain().steady_point(), model.a().submatrix(kept, kept, rest, rest));
    let coupling = Mat::from_fn(rest, kept + nu, |i, j| {
        if j < kept { model.a()[(kept + i, j)] } else { model.b()[(kept + i, j - kept)] }
    });
    let x2 = solve(
        "the steady-state matrix of the eliminated states",
        steady.as_ref(),
        coupling.as_ref(),
    )?;
    let (x2_x, x2_u) = (x2.subcols(0, kept), x2.subcols(kept, nu));
    let a12 = model.a().submatrix(0, kept, kept, rest);
    let c2 = model.c().submatrix(0, kept, ny, rest);
    StateSpace::new(
        model.a().submatrix(0, 0, kept, kept) + a12 * x2_x,
        model.b().submatrix(0, 0, kept, nu) + a12 * x2_u,
        model.c().submatrix(0, 0, ny, kept) + c2 * x2_x,
        model.d() + c2 * x2_u,
        model.domain(),
    )
}
