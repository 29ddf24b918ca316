//! Which directions of the state space an unknown input takes, as a table of a spec.

use faer::{Mat, MatRef};
use fd_core::{Shape, ShapeError};
use fd_model::{Discrete, Record, StateSpace, uncertainty::MatrixPerturbation};
use fd_residual::{
    DesignError,
    analysis::UnknownInputs,
    disturbance::{Directions, Expectation},
};
use serde::{Deserialize, Serialize};

use super::parameter::{ShiftSpec, dense};

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
    /// The principal directions in which random models around the given one differ from it, where
    /// the inputs of the healthy training logs take them.
    Perturbed {
        /// How many; fewer than there are outputs.
        rank: usize,
        /// How each model is drawn; `C` and `D` do not matter.
        #[serde(default)]
        perturbation: MatrixPerturbation,
        /// Number of models.
        #[serde(default = "default_models")]
        models: u32,
        /// Seed of the first model.
        #[serde(default)]
        seed: u64,
    },
    /// The same for given models, such as those of several operating points or units.
    Models {
        /// How many; fewer than there are outputs.
        rank: usize,
        /// What each adds to the (scaled, discrete) model.
        shifts: Vec<ShiftSpec>,
    },
}

fn default_models() -> u32 {
    50
}

fn default_noise() -> f64 {
    0.1
}

/// Samples over which a disturbance changes, unless the spec says otherwise.
const DURATION: f64 = 10.0;

impl DisturbanceSpec {
    /// The unknown-input matrix `E`, each column that is not given as long as its root mean square.
    ///
    /// # Errors
    ///
    /// Returns an error when a column or shift does not have the sizes of the model, or models or
    /// healthy logs do not show as many directions.
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
            Self::Perturbed { rank, perturbation, models, seed } => {
                let draw = |i| Ok(perturbation.draw(model, seed.wrapping_add(i))?.model);
                let models: Result<Vec<_>, DesignError> =
                    (0..u64::from(*models)).map(draw).collect();
                spread(model, &models?, healthy, *rank)
            }
            Self::Models { rank, shifts } => {
                let shifted = |shift: &ShiftSpec| {
                    let (da, db) = (dense(&shift.a), dense(&shift.b));
                    check("shift of A", &da, model.a())?;
                    check("shift of B", &db, model.b())?;
                    let (a, b) = (model.a() + da, model.b() + db);
                    let (c, d) = (model.c().to_owned(), model.d().to_owned());
                    Ok(StateSpace::new(a, b, c, d, model.domain())?)
                };
                let models: Result<Vec<_>, DesignError> = shifts.iter().map(shifted).collect();
                spread(model, &models?, healthy, *rank)
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

/// Directions in which models differ from the first, where the inputs of logs take them.
fn spread(
    model: &StateSpace<Discrete>,
    others: &[StateSpace<Discrete>],
    healthy: &[Record],
    rank: usize,
) -> Result<Mat<f64>, DesignError> {
    let energy = Directions::energy(model, healthy)?;
    Directions::from_models(model, others, &energy)?.scaled(rank)
}

fn check(role: &'static str, shift: &Mat<f64>, of: MatRef<'_, f64>) -> Result<(), DesignError> {
    let expected = Shape::new(of.nrows(), of.ncols());
    let found = Shape::new(shift.nrows(), shift.ncols());
    if expected == found { Ok(()) } else { Err(ShapeError { role, expected, found }.into()) }
}
