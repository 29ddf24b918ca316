//! Random perturbation of physical parameters.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::{
    domain::TimeDomain,
    error::ModelError,
    state_space::StateSpace,
    uncertainty::draw::{Draw, check_fraction, until_stable},
};

/// A random stable model and the parameters behind it.
#[derive(Clone, Debug)]
pub struct ParameterDraw<D> {
    /// Perturbed model and the number of unstable ones before it.
    pub draw: Draw<D>,
    /// Its parameters, in the order and units of the nominal ones.
    pub parameters: Vec<f64>,
}

/// Multiplies each parameter by a factor of its own, uniform in `1 ± fraction`, until the model
/// made of them is stable. The same seed gives the same parameters.
///
/// Unlike independent changes of matrix entries, this keeps the structure of the model: a mass
/// that is 10 % larger changes all entries it occurs in alike.
///
/// # Errors
///
/// Returns an error when the fraction is negative or not finite, the nominal model is unstable,
/// a thousand draws in a row are, or `model` fails.
///
/// # Examples
///
/// ```
/// use faer::{Mat, mat};
/// use fd_model::{Continuous, StateSpace, uncertainty::perturb_parameters};
///
/// // Mass, damper and spring in kg, N·s/m and N/m.
/// let model = |p: &[f64]| {
///     let [m, d, k] = [p[0], p[1], p[2]];
///     let a = mat![[0.0, 1.0], [-k / m, -d / m]];
///     StateSpace::new(a, mat![[0.0], [1.0 / m]], mat![[1.0, 0.0]], Mat::zeros(1, 1), Continuous)
/// };
/// let plant = perturb_parameters(&[1.0, 0.5, 4.0], 0.1, 3, model)?;
/// assert_eq!(plant.draw.model.a()[(0, 1)], 1.0);
/// assert!((plant.parameters[2] - 4.0).abs() <= 0.4);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
pub fn perturb_parameters<D: TimeDomain>(
    nominal: &[f64],
    fraction: f64,
    seed: u64,
    mut model: impl FnMut(&[f64]) -> Result<StateSpace<D>, ModelError>,
) -> Result<ParameterDraw<D>, ModelError> {
    check_fraction(fraction)?;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let nominal_model = model(nominal)?;
    let (draw, parameters) = until_stable(&nominal_model, || {
        let factor = |p: &f64| p * (1.0 + fraction * rng.random_range(-1.0..=1.0));
        let parameters: Vec<f64> = nominal.iter().map(factor).collect();
        Ok((model(&parameters)?, parameters))
    })?;
    Ok(ParameterDraw { draw, parameters })
}
