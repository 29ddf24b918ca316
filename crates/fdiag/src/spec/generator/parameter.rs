//! Which parameters an adaptive observer follows, as a table of a spec.

use faer::Mat;
use fd_model::{Discrete, StateSpace};
use fd_residual::{DesignError, adaptive::ParameterShift};
use serde::{Deserialize, Serialize};

/// Parameters of the plant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ParameterSpec {
    /// The relative error of the gain of each input.
    InputGains {},
    /// The relative error of the rate of change of each state.
    StateRates {},
    /// Given by what each adds to the model per unit.
    Matrices {
        /// One per parameter.
        shifts: Vec<ShiftSpec>,
    },
}

/// What one parameter adds to the discrete model per unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShiftSpec {
    /// Rows of `ΔA`.
    pub a: Vec<Vec<f64>>,
    /// Rows of `ΔB`.
    pub b: Vec<Vec<f64>>,
}

impl ParameterSpec {
    /// The shifts for a model.
    ///
    /// # Errors
    ///
    /// Returns an error when a matrix has a hole or is not finite; sizes are checked by the design.
    pub fn shifts(&self, model: &StateSpace<Discrete>) -> Result<Vec<ParameterShift>, DesignError> {
        match self {
            Self::InputGains {} => Ok(ParameterShift::input_gains(model)),
            Self::StateRates {} => Ok(ParameterShift::state_rates(model)),
            Self::Matrices { shifts } => {
                let shift = |s: &ShiftSpec| ParameterShift::new(dense(&s.a), dense(&s.b));
                shifts.iter().map(shift).collect()
            }
        }
    }
}

/// Rows as a matrix, with NaN where a row is too short.
pub(super) fn dense(rows: &[Vec<f64>]) -> Mat<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    Mat::from_fn(rows.len(), columns, |i, j| rows[i].get(j).copied().unwrap_or(f64::NAN))
}
