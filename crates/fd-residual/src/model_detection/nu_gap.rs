//! The ν-gap metric.

use faer::{Mat, Scale, prelude::Solve};
use fd_model::{ModelError, StateSpace, TimeDomain};
use fd_numeric::dense::Dense;

use crate::{
    error::DesignError,
    form::peak_gain,
    kalman::{Noises, filter},
    matrix::blocks,
};

/// States that are reached or seen by less than this, relatively, are not.
const MINIMAL: f64 = 1e-10;

/// The ν-gap of two models, between 0 and 1: how differently they behave under the same feedback.
///
/// `δ_ν = ‖G̃₂ G₁‖∞` with normalised coprime factors `G̃₂ = [−M̃₂ Ñ₂]` and `G₁ = [N₁; M₁]`, if the winding number of
/// `det(I + G₂~ G₁)` fits the numbers of unstable poles, and 1 otherwise (Vinnicombe 1993). The condition is that the
/// loop of `G₁` with `G₂~` has as many stable modes as `G₁` has states. A controller that keeps a stability margin
/// `b > δ_ν` with one of the models stabilises the other.
///
/// Measure all inputs in units of their range, and outputs too: the metric compares gains with one.
///
/// # Errors
///
/// Returns an error when channels or sample times differ, or a Riccati equation has no solution because a mode that
/// does not decay is hidden.
///
/// # Examples
///
/// Two lags with poles on either side of the axis are close, because any fast loop treats them alike
/// (Zhou and Doyle, "Essentials of Robust Control", 1998, example 17.2):
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace};
/// use fd_residual::model_detection::nu_gap;
///
/// let first = |a: f64| StateSpace::new(mat![[a]], mat![[50.0]], mat![[1.0]], mat![[0.0]], Continuous);
/// let gap = nu_gap(&first(-0.5)?, &first(0.5)?)?; // 100/(2 s + 1) and 100/(2 s − 1)
/// assert!((gap - 0.02).abs() < 1e-5, "{gap}");
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
pub fn nu_gap<D: TimeDomain>(
    one: &StateSpace<D>,
    other: &StateSpace<D>,
) -> Result<f64, DesignError> {
    // Channels are compared by the difference.
    one.difference(other)?;
    let (one, other) = (one.minimal(MINIMAL)?, other.minimal(MINIMAL)?);
    if !winding_fits(&one, &other)? {
        return Ok(1.0);
    }
    let graph = transposed(&left_coprime(&transposed(&one)?)?)?;
    // [Ñ −M̃] of the other model on [M; N] of this one; the dual gives [N; −M].
    let left = left_coprime(&other)?;
    let (nu, ny) = (one.nu(), one.ny());
    let swap = Mat::from_fn(nu + ny, nu + ny, |i, j| match (i < nu, j < ny) {
        (true, false) if i == j - ny => -1.0,
        (false, true) if i - nu == j => 1.0,
        _ => 0.0,
    });
    let swap = StateSpace::gain(swap, one.domain())?;
    let product = graph.series(&swap)?.series(&left)?;
    Ok(peak_gain(&product)?.norm.min(1.0))
}

/// The stable system `[Ñ −M̃]` with `G = M̃⁻¹ Ñ` and `Ñ Ñ~ + M̃ M̃~ = I`: the whitened innovations, but for their sign, of
/// the filter for noise of unit size on all inputs and outputs.
fn left_coprime<D: TimeDomain>(g: &StateSpace<D>) -> Result<StateSpace<D>, DesignError> {
    let (a, b, c, d) = (g.a(), g.b(), g.c(), g.d());
    let one = Mat::<f64>::identity(g.ny(), g.ny());
    let noises = Noises { q: b * b.transpose(), s: b * d.transpose(), r: &one + d * d.transpose() };
    let found = filter(g.domain(), a, c, &noises)?;
    let failed = ModelError::NoConvergence { what: "coprime factors", order: g.nx() };
    let root = found.innovation.cholesky().map_err(|_| failed)?;
    let scale = root.L().lu().solve(&one);
    let l = &found.gain;
    let from = blocks(&[&[(b - l * d).as_ref(), l.as_ref()]]);
    let direct = blocks(&[&[d, (Scale(-1.0) * &one).as_ref()]]);
    Ok(StateSpace::new(a - l * c, from, &scale * c, &scale * direct, g.domain())?)
}

fn transposed<D: TimeDomain>(g: &StateSpace<D>) -> Result<StateSpace<D>, DesignError> {
    let [a, b, c, d] = [g.a(), g.c(), g.b(), g.d()].map(|m| m.transpose().to_owned());
    Ok(StateSpace::new(a, b, c, d, g.domain())?)
}

/// Whether `(I + G₂~ G₁)⁻¹` has as many stable modes as `G₁` has states, and none on the axis.
fn winding_fits<D: TimeDomain>(
    one: &StateSpace<D>,
    other: &StateSpace<D>,
) -> Result<bool, DesignError> {
    let (one, other) = (D::half_plane(one)?, D::half_plane(other)?);
    // G~(s) = G(−s)ᵀ
    let [a, c, b, d] =
        [other.a(), other.b(), other.c(), other.d()].map(|m| m.transpose().to_owned());
    let mirrored = StateSpace::new(Scale(-1.0) * a, Scale(-1.0) * b, c, d, other.domain())?;
    let closed = match one.feedback(&mirrored) {
        // I + D₂ᵀ D₁ is singular: the condition fails at infinite frequency.
        Err(ModelError::Singular { .. }) => return Ok(false),
        closed => closed?,
    };
    let poles = closed.poles()?;
    Ok(poles.iter().filter(|pole| pole.re < 0.0).count() == one.nx()
        && poles.iter().all(|pole| 1e-12 * pole.norm() < pole.re.abs()))
}
