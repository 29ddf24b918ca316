//! A model that the plant may be.

use fd_model::{Discrete, StateSpace, TimeDomain};

use crate::analysis::UnknownInputs;

/// A named model with the disturbances and the noise that it knows.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace};
/// use fd_residual::{analysis::UnknownInputs, model_detection::PlantModel};
///
/// let lag = StateSpace::new(mat![[-7.0]], mat![[7.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
/// let noise = UnknownInputs::none(&lag).sensor(&lag, 0)?;
/// let half = PlantModel::new("half efficiency", lag).with_noise(noise);
/// assert_eq!((half.name(), half.noise().len()), ("half efficiency", 1));
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PlantModel<D = Discrete> {
    name: String,
    plant: StateSpace<D>,
    disturbances: UnknownInputs,
    noise: UnknownInputs,
}

impl<D: TimeDomain> PlantModel<D> {
    /// A model without disturbances and noise.
    #[must_use]
    pub fn new(name: &str, plant: StateSpace<D>) -> Self {
        let none = UnknownInputs::none(&plant);
        Self { name: name.to_owned(), plant, disturbances: none.clone(), noise: none }
    }

    /// With disturbances that its residual must not show.
    #[must_use]
    pub fn with_disturbances(self, disturbances: UnknownInputs) -> Self {
        Self { disturbances, ..self }
    }

    /// With white noise of unit intensity.
    #[must_use]
    pub fn with_noise(self, noise: UnknownInputs) -> Self {
        Self { noise, ..self }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// From known inputs to outputs.
    #[must_use]
    pub fn plant(&self) -> &StateSpace<D> {
        &self.plant
    }

    /// The disturbances.
    #[must_use]
    pub fn disturbances(&self) -> &UnknownInputs {
        &self.disturbances
    }

    /// The noise.
    #[must_use]
    pub fn noise(&self) -> &UnknownInputs {
        &self.noise
    }
}
