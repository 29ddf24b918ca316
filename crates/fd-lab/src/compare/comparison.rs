//! The result of a comparison.

use serde::{Deserialize, Serialize};

use super::{config::CompareConfig, overall::Overall, result::ScenarioResult};

/// The version of the JSON report.
pub const REPORT_VERSION: u32 = 2;

/// The result of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Version of this schema.
    pub version: u32,
    /// What was compared.
    pub config: CompareConfig,
    /// Rates of false alarms per run behind the ROC, the wanted one first.
    pub rates: Vec<f64>,
    /// All entries over all scenarios, the best first.
    pub overall: Vec<Overall>,
    /// Every scenario with its entries, the best first.
    pub scenarios: Vec<ScenarioResult>,
}
