//! Thresholds that follow the input, as lines of a spec.

use faer::{Mat, Scale};
use fd_compensate::{
    DrivenRows,
    calibrate::FalseAlarms,
    detect::{
        DetectorError,
        adaptive::{Bands, Evaluation, InputBound, LearnedBound, noise_levels},
    },
};
use fd_model::{
    Continuous, Discrete, ModelError, StateSpace,
    uncertainty::{MatrixPerturbation, Uncertainty},
};
use serde::{Deserialize, Serialize};

use super::detector_data::{DetectorData, DetectorSpecError};

/// The bound `a + Σ b ‖φ u‖` on what a wrong model leaves in the residual.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AdaptiveSpec {
    /// What the bound is made from.
    #[serde(default)]
    pub bound: BoundSpec,
    /// Corners between the frequency bands of the input.
    #[serde(default = "default_corners")]
    pub corners: usize,
    /// Time constant in samples of the slowest corner; the fastest lies at 1 rad per sample.
    #[serde(default = "default_slowest")]
    pub slowest_samples: f64,
    /// Memory in samples of the root mean squares.
    #[serde(default = "default_memory")]
    pub memory_samples: f64,
    /// How far beyond the largest norms in the healthy logs, relative to them, those of the inputs may go before the
    /// threshold is said to be void.
    #[serde(default = "default_void_margin")]
    pub void_margin: f64,
    /// Rate of false alarms that the factor on the bound is calibrated for.
    pub false_alarms: FalseAlarms,
}

/// What a bound is made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum BoundSpec {
    /// The healthy logs: a high quantile of the residual, given the input.
    Learned {
        /// That quantile, before the calibration.
        #[serde(default = "default_quantile")]
        quantile: f64,
    },
    /// Models with perturbed matrices: the largest gain of `H_y ΔG` at each frequency.
    Ensemble {
        /// How many.
        #[serde(default = "default_models")]
        models: usize,
        /// Relative perturbation of each entry, those of `A − I` for `A`: they are the rates of the model.
        #[serde(default = "default_fraction")]
        fraction: f64,
        /// Seed of the first model.
        #[serde(default = "default_seed")]
        seed: u64,
    },
}

impl Default for BoundSpec {
    fn default() -> Self {
        Self::Learned { quantile: default_quantile() }
    }
}

fn default_corners() -> usize {
    4
}

fn default_slowest() -> f64 {
    100.0
}

fn default_memory() -> f64 {
    50.0
}

fn default_void_margin() -> f64 {
    0.1
}

fn default_quantile() -> f64 {
    LearnedBound::default().quantile
}

fn default_models() -> usize {
    30
}

fn default_fraction() -> f64 {
    MatrixPerturbation::default().fraction
}

fn default_seed() -> u64 {
    1992
}

/// Draws that turn out unstable, per model wanted, before the search is given up.
const MOST_REDRAWS: u64 = 50;

/// A bound but for what fault-free samples have to tell: which inputs there were, and more.
pub(super) struct Recipe {
    source: Source,
    void_margin: f64,
}

/// What else they tell.
enum Source {
    /// All of it.
    Learned(Bands, LearnedBound),
    /// The noise alone: the rest is a matter of models.
    Ensemble(InputBound),
}

impl Recipe {
    pub(super) fn bound(&self, healthy: DrivenRows<'_>) -> Result<InputBound, DetectorError> {
        let bound = match &self.source {
            Source::Learned(bands, learned) => {
                InputBound::from_fault_free(healthy, bands.clone(), learned)?
            }
            Source::Ensemble(bound) => {
                bound.clone().with_noise(&noise_levels(healthy.residuals())?)?
            }
        };
        bound.known_on(healthy, self.void_margin)
    }
}

impl AdaptiveSpec {
    /// How the bound is made for what `evaluation` compares with it.
    pub(super) fn recipe(
        &self,
        data: &DetectorData<'_>,
        evaluation: Evaluation,
    ) -> Result<Recipe, DetectorSpecError> {
        let bands = Bands::spaced(self.slowest_samples, self.corners, self.memory_samples)?;
        let source = match self.bound {
            BoundSpec::Learned { quantile } => {
                Source::Learned(bands, LearnedBound { quantile, evaluation })
            }
            BoundSpec::Ensemble { models, fraction, seed } => {
                let h_y = data.design.form()?.hy()?;
                let transfers = perturbed(data.model, models, fraction, seed)?
                    .iter()
                    .map(|plant| {
                        Uncertainty::between(data.model, plant)?.residual_transfer(&h_y, data.model)
                    })
                    .collect::<Result<Vec<_>, ModelError>>()?;
                let noise = noise_levels(data.healthy.residuals())?;
                Source::Ensemble(InputBound::over_ensemble(&transfers, bands, &noise)?)
            }
        };
        Ok(Recipe { source, void_margin: self.void_margin })
    }
}

/// Stable models whose rates, `(A − I)/Ts`, and other matrices are perturbed entry by entry.
///
/// Entries of `A` itself would be the wrong thing to perturb: near the unit circle a per cent of one is a
/// multiple of the rate that it stands for.
fn perturbed(
    nominal: &StateSpace<Discrete>,
    models: usize,
    fraction: f64,
    seed: u64,
) -> Result<Vec<StateSpace<Discrete>>, ModelError> {
    let ts = nominal.domain().ts.seconds();
    let one = Mat::<f64>::identity(nominal.nx(), nominal.nx());
    let rates = StateSpace::new(
        Scale(ts.recip()) * (nominal.a() - &one),
        Scale(ts.recip()) * nominal.b(),
        nominal.c().to_owned(),
        nominal.d().to_owned(),
        Continuous,
    )?;
    let perturbation = MatrixPerturbation { fraction, ..MatrixPerturbation::default() };
    let mut found = Vec::with_capacity(models);
    for draw in 0..MOST_REDRAWS * models as u64 {
        if found.len() == models {
            break;
        }
        let drawn = perturbation.draw(&rates, seed.wrapping_add(draw))?.model;
        let plant = StateSpace::new(
            &one + Scale(ts) * drawn.a(),
            Scale(ts) * drawn.b(),
            drawn.c().to_owned(),
            drawn.d().to_owned(),
            nominal.domain(),
        )?;
        if plant.is_stable()? {
            found.push(plant);
        }
    }
    if found.len() < models {
        let (what, order) = ("the search for stable perturbations", nominal.nx());
        return Err(ModelError::NoConvergence { what, order });
    }
    Ok(found)
}
