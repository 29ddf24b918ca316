//! The scale and the colour of the noise of each output.

use std::sync::Arc;

use super::unknown::Unknown;
use crate::quality::Autoregression;

/// What residuals are divided by and filtered with.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    /// Standard deviation of the noise of each output, in its unit.
    pub sigma: Vec<f64>,
    /// Colour of the noise of each output.
    pub colour: Vec<Autoregression>,
    /// What unknown disturbances add to that, in units of the noise.
    pub unknown: Option<Arc<Unknown>>,
}

impl Weights {
    /// White noise.
    ///
    /// ```
    /// use fd_gap::fit::Weights;
    ///
    /// assert_eq!(Weights::white(vec![0.1, 2.0]).colour[1].order(), 0);
    /// ```
    #[must_use]
    pub fn white(sigma: Vec<f64>) -> Self {
        let colour = vec![Autoregression::white(); sigma.len()];
        Self { sigma, colour, unknown: None }
    }
}
