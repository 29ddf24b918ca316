//! Hammerstein models at design time.

use fd_core::Scalar;
use fd_model::Record;

use super::{Expanded, Expansion};
use crate::{
    arx::{ArxModel, ArxSimulator, Start},
    error::IdentError,
};

/// Functions of the inputs, and difference equations driven by them.
#[derive(Clone, Debug, PartialEq)]
pub struct HammersteinModel {
    expansion: Expansion,
    linear: ArxModel,
}

impl HammersteinModel {
    /// A model from its parts.
    ///
    /// # Errors
    ///
    /// Returns an error unless the equations have one input per function.
    pub fn new(expansion: Expansion, linear: ArxModel) -> Result<Self, IdentError> {
        let (expected, found) = (expansion.expanded_len(), linear.nu());
        if expected != found {
            return Err(IdentError::ModelMismatch { what: "number of inputs", expected, found });
        }
        Ok(Self { expansion, linear })
    }

    /// The functions of the inputs.
    #[must_use]
    pub fn expansion(&self) -> &Expansion {
        &self.expansion
    }

    /// The equations behind them.
    #[must_use]
    pub fn linear(&self) -> &ArxModel {
        &self.linear
    }

    /// Steady bias of one residual channel for constant inputs.
    #[must_use]
    pub fn steady(&self, channel: usize, u: &[f64]) -> f64 {
        let mut x = vec![0.0; self.linear.nu()];
        self.expansion.freeze::<f64>().expand_into(u, &mut x);
        let driven: f64 =
            x.iter().enumerate().map(|(i, x)| self.linear.dc_gain(channel, i) * x).sum();
        let feedback = 1.0 + self.linear.a(channel).iter().sum::<f64>();
        driven + self.linear.offset(channel) / feedback
    }

    /// Simulates the record from its inputs alone, as
    /// [`ArxModel::simulate_record`](crate::arx::ArxModel::simulate_record).
    ///
    /// # Errors
    ///
    /// As there, and when the record has other channels.
    pub fn simulate_record(&self, record: &Record, start: Start) -> Result<Vec<f64>, IdentError> {
        self.linear.simulate_record(&self.expansion.expand(record)?, start)
    }

    /// Moves the model to run time.
    ///
    /// # Errors
    ///
    /// Never fails for a model that was checked by [`HammersteinModel::new`].
    pub fn freeze<T: Scalar>(&self) -> Result<Expanded<T, ArxSimulator<T>>, IdentError> {
        Expanded::new(&self.expansion, self.linear.freeze()?)
    }
}
