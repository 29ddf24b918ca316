//! What lasting faults of sensors and actuators leave in a residual.

use faer::Mat;
use fd_residual::{DesignError, GeneratorDesign};
use serde::{Deserialize, Serialize};

/// Which faults are thought of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultSites {
    /// One fault for each output.
    #[default]
    Sensors,
    /// One fault for each input.
    Actuators,
    /// Sensors first, then actuators.
    Both,
}

impl FaultSites {
    /// Steady residual for a lasting fault of size 1 at each site, in the (scaled) unit of the channel.
    ///
    /// A sensor fault enters with the output, `H_y`; an actuator fault `f` moves the plant by `G f` while the
    /// generator is told `u`, which leaves `H_y G f = −H_u f` (Patton & Chen 1992, eq. 5 and 6).
    ///
    /// # Errors
    ///
    /// Returns an error when the generator has no steady response.
    pub fn signatures(self, design: &dyn GeneratorDesign) -> Result<Vec<Vec<f64>>, DesignError> {
        let form = design.form()?;
        let mut all = Vec::new();
        if self != Self::Actuators {
            all.extend(columns(&form.hy()?.dc_gain()?, 1.0));
        }
        if self != Self::Sensors {
            all.extend(columns(&form.hu()?.dc_gain()?, -1.0));
        }
        Ok(all)
    }

    /// Names of the sites, in the order of the signatures.
    #[must_use]
    pub fn names(self, design: &dyn GeneratorDesign) -> Vec<String> {
        let io = design.io();
        let sensors =
            (1..=io.ny).map(|i| format!("sensor {i}")).filter(|_| self != Self::Actuators);
        let actuators = (1..=io.nu).map(|j| format!("actuator {j}"));
        sensors.chain(actuators.filter(|_| self != Self::Sensors)).collect()
    }
}

fn columns(gain: &Mat<f64>, sign: f64) -> Vec<Vec<f64>> {
    (0..gain.ncols()).map(|j| (0..gain.nrows()).map(|i| sign * gain[(i, j)]).collect()).collect()
}
