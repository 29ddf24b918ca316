//! What a particle filter is made from.

use super::run::BootstrapFilter;
use crate::{error::NonlinearError, noise::NoisyModel};

/// Most particles of a filter.
const MOST: usize = 1_000_000;

/// A bootstrap particle filter.
#[derive(Clone, Debug)]
pub struct ParticleDesign {
    model: NoisyModel,
    particles: usize,
    seed: u64,
}

impl ParticleDesign {
    /// The filter of this model and its noises, with so many particles.
    ///
    /// # Errors
    ///
    /// Returns an error when there are fewer than two particles or more than a million.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::{Frame, Heap, stage::ResidualGenerator};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_nonlinear::{Noise, NoisyModel, PlantEquations, particle::ParticleDesign};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let equations = PlantEquations::new(lag.freeze::<f64, Heap>()?);
    /// let noise = Noise { process: vec![0.1], output: vec![0.2], initial: vec![1.0] };
    /// let design = ParticleDesign::new(NoisyModel::new(equations, vec![0.0], noise)?, 2000, 7)?;
    /// let (mut filter, mut again, mut r) = (design.freeze(), design.freeze(), [[0.0]; 2]);
    /// for k in 0..20 {
    ///     filter.step(Frame::new(filter.io(), k, &[1.0], &[2.0])?, &mut r[0]);
    ///     again.step(Frame::new(again.io(), k, &[1.0], &[2.0])?, &mut r[1]);
    /// }
    /// // It has settled where the lag has, to within its own noise, and has a seed.
    /// assert!(r[0][0].abs() < 0.05 && r[0] == r[1]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(model: NoisyModel, particles: usize, seed: u64) -> Result<Self, NonlinearError> {
        if !(2..=MOST).contains(&particles) {
            let (setting, expected) = ("particles", "2 to 1000000");
            return Err(NonlinearError::Setting { setting, expected, found: particles as f64 });
        }
        Ok(Self { model, particles, seed })
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &NoisyModel {
        &self.model
    }

    /// Moves the filter to run time, at its start.
    #[must_use]
    pub fn freeze(&self) -> BootstrapFilter {
        BootstrapFilter::new(&self.model, self.particles, self.seed)
    }
}
