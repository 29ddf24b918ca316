//! Random perturbation of the matrices of a model.

use faer::{Mat, MatRef, Scale};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use crate::{
    domain::TimeDomain,
    error::ModelError,
    linalg::svd,
    state_space::StateSpace,
    uncertainty::draw::{Draw, check_fraction, until_stable},
};

/// How a perturbation spreads over a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Spread {
    /// Each entry by a factor of its own, uniform in `1 ± fraction`. Zeros stay zero, and units
    /// do not matter.
    ElementWise,
    /// The whole matrix by `ΔM` with `‖ΔM‖₂` uniform in `[0, fraction ‖M‖₂]` and a random
    /// direction. Zeros do not stay zero; only for models that are scaled per unit, because the
    /// largest entries set the size of the change of all.
    NormBounded,
}

/// Random perturbation of the matrices of a model.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace, uncertainty::MatrixPerturbation};
///
/// let nominal = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
/// let ten_percent = MatrixPerturbation::default();
/// let draw = ten_percent.draw(&nominal, 7)?;
/// assert!((draw.model.a()[(0, 0)] / -2.0 - 1.0).abs() <= 0.1);
/// assert_eq!(draw.model.a(), ten_percent.draw(&nominal, 7)?.model.a());
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MatrixPerturbation {
    /// How the perturbation spreads over each matrix; entry by entry by default.
    pub spread: Spread,
    /// Relative size; 0.1 by default, the paper's 10 %.
    pub fraction: f64,
    /// Which matrices are perturbed, in the order `A, B, C, D`; all by default.
    pub matrices: [bool; 4],
}

impl Default for MatrixPerturbation {
    fn default() -> Self {
        Self { spread: Spread::ElementWise, fraction: 0.1, matrices: [true; 4] }
    }
}

impl MatrixPerturbation {
    /// Draws perturbed models until one is stable. The same seed gives the same model.
    ///
    /// # Errors
    ///
    /// Returns an error when the fraction is negative or not finite, the nominal model is
    /// unstable, or a thousand draws in a row are.
    pub fn draw<D: TimeDomain>(
        &self,
        nominal: &StateSpace<D>,
        seed: u64,
    ) -> Result<Draw<D>, ModelError> {
        check_fraction(self.fraction)?;
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let (draw, ()) = until_stable(nominal, || {
            let mut part = |chosen: bool, matrix: MatRef<'_, f64>| {
                if chosen { self.perturb(matrix, &mut rng) } else { Ok(matrix.to_owned()) }
            };
            let [in_a, in_b, in_c, in_d] = self.matrices;
            let model = StateSpace::new(
                part(in_a, nominal.a())?,
                part(in_b, nominal.b())?,
                part(in_c, nominal.c())?,
                part(in_d, nominal.d())?,
                nominal.domain(),
            )?;
            Ok((model, ()))
        })?;
        Ok(draw)
    }

    fn perturb(
        &self,
        matrix: MatRef<'_, f64>,
        rng: &mut Xoshiro256PlusPlus,
    ) -> Result<Mat<f64>, ModelError> {
        let mut uniform = |_, _| rng.random_range(-1.0..=1.0_f64);
        match self.spread {
            Spread::ElementWise => Ok(Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
                matrix[(i, j)] * (1.0 + self.fraction * uniform(i, j))
            })),
            Spread::NormBounded => {
                let direction = Mat::from_fn(matrix.nrows(), matrix.ncols(), &mut uniform);
                let length = norm_2(direction.as_ref())?;
                let size = self.fraction * norm_2(matrix)? * uniform(0, 0).abs();
                let scale = if 0.0 < length { size / length } else { 0.0 };
                Ok(matrix + Scale(scale) * direction)
            }
        }
    }
}

/// Largest singular value.
fn norm_2(matrix: MatRef<'_, f64>) -> Result<f64, ModelError> {
    Ok(svd(matrix)?.values.first().copied().unwrap_or(0.0))
}
