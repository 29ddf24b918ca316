//! What the methods are compared on.

use fd_model::fault::Site;
use serde::{Deserialize, Serialize};

use super::own::OwnPlant;
use crate::engine::PlantConfig;

/// What the methods are compared on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// A short name.
    pub name: String,
    /// What it is meant to show, in a sentence.
    #[serde(default)]
    pub about: String,
    /// The plant and what makes it differ from its model.
    #[serde(default)]
    pub plant: PlantConfig,
    /// A plant of one's own instead of the engine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own: Option<OwnPlant>,
    /// A fault that is there already while the bias is learned; the faults to be found are then
    /// on top of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub present: Option<Present>,
}

/// A fault that was there before anybody looked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Present {
    /// Where.
    pub site: Site,
    /// Its size, a share of the reading or of the component's parameter.
    pub size: f64,
    /// Whether it was there while the bias was learned and the detectors were scaled. Without this
    /// it comes after that, as deterioration does, and is a fault to be found itself.
    #[serde(default)]
    pub while_learning: bool,
}
