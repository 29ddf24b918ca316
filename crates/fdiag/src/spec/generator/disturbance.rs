//! Which directions of the state space an unknown input takes, as a table of a spec.

use faer::Mat;
use fd_model::{Discrete, Record, StateSpace};
use fd_residual::{
    DesignError,
    analysis::UnknownInputs,
    disturbance::{Directions, Expectation},
};
use serde::{Deserialize, Serialize};

/// Where the columns of the unknown-input matrix `E` come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum DisturbanceSpec {
    /// Given, each with one entry per state of the (scaled) model.
    Directions {
        /// The columns of `E`.
        columns: Vec<Vec<f64>>,
    },
    /// The principal directions of the disturbances that explain the healthy training logs.
    Learned {
        /// How many; fewer than there are outputs.
        rank: usize,
        /// Time in s over which the disturbance changes; ten samples without it.
        #[serde(default)]
        duration_s: Option<f64>,
        /// Standard deviation of the output noise over that of the disturbance per sample.
        #[serde(default = "default_noise")]
        output_noise: f64,
    },
}

fn default_noise() -> f64 {
    0.1
}

/// Samples over which a disturbance changes, unless the spec says otherwise.
const DURATION: f64 = 10.0;

impl DisturbanceSpec {
    /// The unknown-input matrix `E`, each learned column as long as its root mean square.
    ///
    /// # Errors
    ///
    /// Returns an error when a column has not one entry per state, or the healthy logs do not
    /// show as many directions.
    pub fn columns(
        &self,
        model: &StateSpace<Discrete>,
        healthy: &[Record],
    ) -> Result<Mat<f64>, DesignError> {
        match self {
            Self::Directions { columns } => {
                let mut unknown = UnknownInputs::none(model);
                for column in columns {
                    unknown = unknown.component("disturbance", column, &vec![0.0; model.ny()])?;
                }
                Ok(unknown.system(model)?.b().to_owned())
            }
            Self::Learned { rank, duration_s, output_noise } => {
                let ts = model.domain().ts.seconds();
                let expected = Expectation {
                    duration_s: duration_s.unwrap_or(DURATION * ts),
                    output_noise: *output_noise,
                    settle: 0,
                };
                Directions::from_records(model, healthy, &expected)?.scaled(*rank)
            }
        }
    }

    /// The same as unknown inputs of the model.
    ///
    /// # Errors
    ///
    /// As [`DisturbanceSpec::columns`].
    pub fn unknown(
        &self,
        model: &StateSpace<Discrete>,
        healthy: &[Record],
    ) -> Result<UnknownInputs, DesignError> {
        let e = self.columns(model, healthy)?;
        let d = Mat::zeros(model.ny(), e.ncols());
        UnknownInputs::new("disturbance", e, d)
    }
}
