//! Policy for a plant that changes while the switch is open.

use serde::{Deserialize, Serialize};

use super::error::CompensationError;

/// The watch for a change of the plant's characteristics, while the switch is open.
///
/// In windows of so many samples the compensated residual of each channel is explained by the inputs,
/// as they are and through two low-passes, next to a constant and a trend, which are what a sensor fault
/// adds. The plant has changed when
///
/// * the relation of the last window explains at least `share` of what constant and trend leave of the
///   present one, so that it is no chance, and
/// * the root mean square of that is `growth` times the one of the first window after the switch opened,
///   which counts as healthy. It is scaled up when an input moves more than it did there, so that a lively
///   input alone is no change.
///
/// A fault that does not act through the inputs fails the first condition, a small change the second. It
/// takes two windows to see a change, or three when it begins in the middle of one.
///
/// # When not to use it
///
/// When the inputs hardly move, or move as slowly as a window is long: nothing can then tell the two
/// apart, and nothing is reported. When the inputs react to the outputs (a controller): a sensor fault
/// then drives them, and looks like a plant that has changed.
///
/// ```
/// use fd_compensate::residual_compensation::{ChangePolicy, CompensationPlan, PlantChange};
///
/// let plant_change = PlantChange { policy: ChangePolicy::Retrain, ..PlantChange::default() };
/// let plan = CompensationPlan { plant_change, ..CompensationPlan::default() };
/// assert!(plan.check().is_ok());
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlantChange {
    /// What to do about a change; default [`ChangePolicy::Ignore`].
    pub policy: ChangePolicy,
    /// Samples of a window, at least 20: some time constants of the bias; default 400.
    pub window: u64,
    /// Least share of the compensated residual that the inputs must explain; default 0.5.
    pub share: f64,
    /// Least growth of the compensated residual; default 3.
    pub growth: f64,
}

impl Default for PlantChange {
    fn default() -> Self {
        Self { policy: ChangePolicy::default(), window: 400, share: 0.5, growth: 3.0 }
    }
}

/// What to do when the plant has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChangePolicy {
    /// Do not watch.
    #[default]
    Ignore,
    /// Say so and go on.
    Warn,
    /// Say so and train again.
    Retrain,
}

/// Shortest window in samples.
const SHORTEST: u64 = 20;

impl PlantChange {
    pub(super) fn check(&self) -> Result<(), CompensationError> {
        let refuse = |parameter, expected, found| {
            Err(CompensationError::Parameter { parameter, expected, found })
        };
        let Self { window, share, growth, .. } = *self;
        if window < SHORTEST {
            return refuse("plant_change.window", "at least 20", window as f64);
        }
        if !(share > 0.0 && share < 1.0) {
            return refuse("plant_change.share", "between 0 and 1", share);
        }
        if !(growth >= 1.0 && growth.is_finite()) {
            return refuse("plant_change.growth", "finite and at least 1", growth);
        }
        Ok(())
    }
}
