//! What an unscented Kalman filter is made from.

use super::run::UnscentedKalman;
use crate::{error::NonlinearError, noise::NoisyModel};

/// An unscented Kalman filter.
#[derive(Clone, Debug)]
pub struct UnscentedDesign {
    model: NoisyModel,
    kappa: f64,
}

impl UnscentedDesign {
    /// The filter of this model and its noises. Without `kappa` it is `3 − n` for up to three states, and zero
    /// for more.
    ///
    /// # Errors
    ///
    /// Returns an error when `kappa` is negative or not finite, or there is no state.
    ///
    /// # Examples
    ///
    /// A square through which no slope at its foot would go:
    ///
    /// ```
    /// use fd_core::{Frame, stage::ResidualGenerator};
    /// use fd_nonlinear::{Noise, NoisyModel, unscented::UnscentedDesign};
    /// use fd_sim::{model::Model, simulate::StateMap};
    ///
    /// let model: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "square"
    /// sample_time = 1.0
    /// inputs = {}
    /// states = { x = { unit = "1", initial = 0.0, update = "x" } }
    /// outputs = { y = { unit = "1", value = "x^2" } }
    /// "#.parse()?;
    /// let map = StateMap::new(&model, &[], model.sample_time()?)?;
    /// let noise = Noise { process: vec![0.0], output: vec![0.1], initial: vec![2.0] };
    /// let design = UnscentedDesign::new(NoisyModel::new(map, vec![0.0], noise)?, None)?;
    /// let (mut filter, mut r) = (design.freeze(), [0.0]);
    /// filter.step(Frame::new(filter.io(), 0, &[], &[0.0])?, &mut r);
    /// // The mean of x² is the variance of x; a slope would have said zero.
    /// assert!((r[0] + 4.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(model: NoisyModel, kappa: Option<f64>) -> Result<Self, NonlinearError> {
        if model.nx() == 0 {
            let (setting, expected) = ("number of states", "at least 1");
            return Err(NonlinearError::Setting { setting, expected, found: 0.0 });
        }
        let kappa = kappa.unwrap_or_else(|| (3.0 - model.nx() as f64).max(0.0));
        if !(kappa.is_finite() && 0.0 <= kappa) {
            let (setting, expected) = ("kappa", "a finite number, not negative");
            return Err(NonlinearError::Setting { setting, expected, found: kappa });
        }
        Ok(Self { model, kappa })
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &NoisyModel {
        &self.model
    }

    /// Moves the filter to run time, at its start.
    #[must_use]
    pub fn freeze(&self) -> UnscentedKalman {
        UnscentedKalman::new(&self.model, self.kappa)
    }
}
