//! What an extended Kalman filter is made from.

use super::run::ExtendedKalman;
use crate::noise::NoisyModel;

/// An extended Kalman filter.
///
/// # Examples
///
/// A pendulum of which only the sine of its angle is measured:
///
/// ```
/// use fd_core::{Frame, stage::ResidualGenerator};
/// use fd_nonlinear::{Noise, NoisyModel, extended::ExtendedDesign};
/// use fd_sim::{model::Model, simulate::StateMap};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "pendulum"
/// sample_time = 0.02
/// inputs = { u = { unit = "1/s^2" } }
/// outputs = { y = { unit = "1", value = "sin(q)" } }
/// [states]
/// q = { unit = "rad", initial = 0.3, derivative = "w" }
/// w = { unit = "rad/s", initial = 0.0, derivative = "u - 9*sin(q) - 0.2*w" }
/// "#.parse()?;
/// let map = StateMap::new(&model, &model.nominal(), model.sample_time()?)?;
/// let noise = Noise { process: vec![1e-4; 2], output: vec![1e-2], initial: vec![0.5; 2] };
/// let mut filter = ExtendedDesign::new(NoisyModel::new(map.clone(), vec![0.0, 0.0], noise)?).freeze();
///
/// // The plant starts elsewhere. The filter finds it, and its residual dies out.
/// let (mut x, mut next, mut y, mut r) = ([0.3, 0.5], [0.0; 2], [0.0], [0.0]);
/// for k in 0..200 {
///     map.clone().output(k, &x, &[0.0], &mut y);
///     filter.step(Frame::new(filter.io(), k, &[0.0], &y)?, &mut r);
///     map.clone().advance(k, &x, &[0.0], &[0.0], &mut next);
///     x = next;
/// }
/// assert!(r[0].abs() < 1e-3 && (filter.state()[1] - x[1]).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ExtendedDesign {
    model: NoisyModel,
    /// Samples over which the slopes are renewed.
    samples: usize,
}

impl ExtendedDesign {
    /// The filter of this model and its noises.
    #[must_use]
    pub fn new(model: NoisyModel) -> Self {
        Self { model, samples: 1 }
    }

    /// The same filter with slopes that are renewed in turns over so many samples, for models that are dear to
    /// evaluate. With 0 or 1 all are new at every sample, which is the default.
    ///
    /// Choose fewer samples than the plant takes to move from one operating point to another.
    #[must_use]
    pub fn linearised_over(mut self, samples: usize) -> Self {
        self.samples = samples.max(1);
        self
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &NoisyModel {
        &self.model
    }

    /// Moves the filter to run time, at its start.
    #[must_use]
    pub fn freeze(&self) -> ExtendedKalman {
        ExtendedKalman::new(&self.model, self.samples)
    }
}
