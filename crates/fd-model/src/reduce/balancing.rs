//! Balanced coordinates, in which both gramians are the same diagonal matrix.

use faer::Mat;

use crate::{domain::TimeDomain, error::ModelError, linalg::svd, state_space::StateSpace};

/// The leading part of a balanced model.
pub(super) struct Balanced<D> {
    /// The first states in balanced coordinates.
    pub model: StateSpace<D>,
    /// Hankel singular values of all states.
    pub hankel: Vec<f64>,
}

/// The first balanced states: `wanted` if there are as many, but at least `needed`.
///
/// With `L_oᵀ L_c = U Σ Vᵀ`, the balanced states are `Σ^{-1/2} Uᵀ L_oᵀ x`, and
/// `x = L_c V Σ^{-1/2} x_balanced` (Laub et al. 1987).
pub(super) fn balanced_part<D: TimeDomain>(
    model: &StateSpace<D>,
    needed: usize,
    wanted: usize,
) -> Result<Balanced<D>, ModelError> {
    let factors = model.gramian_factors("balancing")?;
    let decomposition =
        svd((factors.observability.transpose() * &factors.controllability).as_ref())?;
    let mut hankel = decomposition.values;

    // Below this, a Hankel value is the rounding error of the largest.
    let floor = hankel.first().map_or(0.0, |largest| model.nx() as f64 * f64::EPSILON * largest);
    let available = hankel.iter().take_while(|&&value| floor < value).count();
    if available < needed {
        let what = "states are both controllable and observable";
        return Err(ModelError::Order { requested: needed, available, what });
    }
    let kept = wanted.min(available);

    let scaled = |factor: Mat<f64>| {
        Mat::from_fn(factor.nrows(), kept, |i, j| factor[(i, j)] / hankel[j].sqrt())
    };
    let to_balanced = scaled(factors.observability * decomposition.u);
    let to_balanced = to_balanced.transpose();
    let from_balanced = scaled(factors.controllability * decomposition.v);
    let part = StateSpace::new(
        to_balanced * model.a() * &from_balanced,
        to_balanced * model.b(),
        model.c() * &from_balanced,
        model.d().to_owned(),
        model.domain(),
    )?;
    hankel.resize(model.nx(), 0.0);
    Ok(Balanced { model: part, hankel })
}
