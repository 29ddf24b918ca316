//! Signatures of lasting sensor and actuator faults in a residual.

use faer::Mat;
use fd_model::{Discrete, StateSpace};
use fd_residual::{DesignError, GeneratorDesign, ResidualForm};
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
        type Part = fn(&ResidualForm) -> Result<StateSpace<Discrete>, DesignError>;
        let (hy, hu): (Part, Part) = (ResidualForm::hy, ResidualForm::hu);
        let form = design.form()?;
        let mut all = Vec::new();
        for (part, sign) in self.in_order([(hy, 1.0)], [(hu, -1.0)]) {
            all.extend(columns(&part(&form)?.dc_gain()?, sign));
        }
        Ok(all)
    }

    /// Names of the sites, in the order of the signatures.
    #[must_use]
    pub fn names(self, design: &dyn GeneratorDesign) -> Vec<String> {
        let io = design.io();
        let sensors = (1..=io.ny).map(|i| format!("sensor {i}"));
        let actuators = (1..=io.nu).map(|j| format!("actuator {j}"));
        self.in_order(sensors, actuators).collect()
    }

    /// What belongs to sensors and actuators, as far as they are thought of, in the order of the
    /// signatures.
    pub fn in_order<T>(
        self,
        sensors: impl IntoIterator<Item = T>,
        actuators: impl IntoIterator<Item = T>,
    ) -> impl Iterator<Item = T> {
        let sensors = sensors.into_iter().filter(move |_| self != Self::Actuators);
        sensors.chain(actuators.into_iter().filter(move |_| self != Self::Sensors))
    }
}

fn columns(gain: &Mat<f64>, sign: f64) -> Vec<Vec<f64>> {
    (0..gain.ncols()).map(|j| (0..gain.nrows()).map(|i| sign * gain[(i, j)]).collect()).collect()
}
