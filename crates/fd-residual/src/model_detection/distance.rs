//! How far models are apart.

use faer::Mat;
use fd_model::{StateSpace, TimeDomain};

use super::{models::PlantModel, nu_gap::nu_gap};
use crate::{error::DesignError, form::peak_gain, matrix::spectral_norm};

/// What is meant by the distance of two models, from known inputs to outputs.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelDistance {
    /// The ν-gap, between 0 and 1; units of inputs and outputs matter.
    NuGap,
    /// Largest gain of the difference over frequency, `‖G_i − G_j‖∞`.
    Peak,
    /// H2 norm of the difference: root mean square of the difference under white inputs. For stable models.
    H2,
    /// Largest gain of the difference at these frequencies (rad/s).
    At(Vec<f64>),
}

/// The distances of all models from each other: symmetric, with zeros on the diagonal.
///
/// # Errors
///
/// Returns an error when models have other channels or sample times than the first, or a norm does not exist.
///
/// # Examples
///
/// An actuator as it should be, and one that is disconnected:
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace};
/// use fd_residual::model_detection::{ModelDistance, PlantModel, distances};
///
/// let lag = |k: f64| StateSpace::new(mat![[-k]], mat![[k]], mat![[1.0]], mat![[0.0]], Continuous);
/// let models = [PlantModel::new("nominal", lag(14.0)?), PlantModel::new("fast", lag(140.0)?)];
/// let found = distances(&models, &ModelDistance::Peak)?;
/// // |G₂ − G₁| = 126 ω / (|14 + jω| |140 + jω|) is largest at ω² = 14 · 140: 126/154.
/// assert!((found[(0, 1)] - 126.0 / 154.0).abs() < 1e-7);
/// assert_eq!(found[(0, 0)], 0.0);
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
pub fn distances<D: TimeDomain>(
    models: &[PlantModel<D>],
    distance: &ModelDistance,
) -> Result<Mat<f64>, DesignError> {
    let mut all = Mat::zeros(models.len(), models.len());
    for (i, one) in models.iter().enumerate() {
        for (j, other) in models.iter().enumerate().take(i) {
            all[(i, j)] = between(one.plant(), other.plant(), distance)?;
            all[(j, i)] = all[(i, j)];
        }
    }
    Ok(all)
}

fn between<D: TimeDomain>(
    one: &StateSpace<D>,
    other: &StateSpace<D>,
    distance: &ModelDistance,
) -> Result<f64, DesignError> {
    let difference = one.difference(other)?;
    Ok(match distance {
        ModelDistance::NuGap => nu_gap(one, other)?,
        ModelDistance::Peak => peak_gain(&difference)?.norm,
        ModelDistance::H2 => difference.h2_norm()?,
        ModelDistance::At(frequencies) => {
            let mut largest = 0.0_f64;
            for &omega in frequencies {
                largest =
                    largest.max(spectral_norm(difference.frequency_response(omega)?.as_ref()));
            }
            largest
        }
    })
}
