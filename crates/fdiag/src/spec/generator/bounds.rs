//! What is bounded, as a table of a spec.

use faer::{Mat, c64};
use fd_model::{Discrete, StateSpace};
use fd_residual::{
    DesignError,
    observer::ObserverDesign,
    zonotope::{Bounds, ModelBounds, ZonotopeDesign},
};
use serde::{Deserialize, Serialize};

use super::parameter::dense;

/// How far each entry of the (scaled, discrete) model may be off; a matrix that is left out is exact.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelBoundSpec {
    /// Rows of the bounds of `A`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub a: Vec<Vec<f64>>,
    /// Rows of the bounds of `B`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub b: Vec<Vec<f64>>,
    /// Rows of the bounds of `C`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub c: Vec<Vec<f64>>,
    /// Rows of the bounds of `D`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub d: Vec<Vec<f64>>,
}

impl ModelBoundSpec {
    fn bounds(&self, model: &StateSpace<Discrete>) -> ModelBounds {
        let mut bounds = ModelBounds::exact(model);
        let given = [&self.a, &self.b, &self.c, &self.d];
        let all = [&mut bounds.a, &mut bounds.b, &mut bounds.c, &mut bounds.d];
        for (bound, rows) in all.into_iter().zip(given) {
            if !rows.is_empty() {
                *bound = dense(rows);
            }
        }
        bounds
    }
}

/// An observer with all poles of its error at one place, and what is bounded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ZonotopeSpec {
    /// Rate at which the error dies out, in 1/s, as that of `observer`.
    pub rate: f64,
    /// Largest noise of each output, in its (scaled) unit.
    pub noise: Vec<f64>,
    /// What each disturbance between -1 and 1 adds to the next state: columns with one entry per (scaled) state.
    #[serde(default)]
    pub disturbance: Vec<Vec<f64>>,
    /// Largest distance of each (scaled) state from zero before the first sample; without it, what the bounds lead to.
    #[serde(default)]
    pub initial: Option<Vec<f64>>,
    /// How far the model may be off.
    #[serde(default)]
    pub model: ModelBoundSpec,
    /// Most columns between samples; without it, ten times the number of states.
    #[serde(default)]
    pub columns: Option<usize>,
}

impl ZonotopeSpec {
    /// The design.
    pub(super) fn design(
        &self,
        model: &StateSpace<Discrete>,
    ) -> Result<ZonotopeDesign, DesignError> {
        let pole = c64::new((-self.rate * model.domain().ts.seconds()).exp(), 0.0);
        let observer = ObserverDesign::place(model, &vec![pole; model.nx()])?;
        let disturbance = match self.disturbance.as_slice() {
            [] => Mat::zeros(model.nx(), 0),
            columns => dense(columns).transpose().to_owned(),
        };
        let bounds = Bounds {
            disturbance,
            noise: self.noise.clone(),
            initial: self.initial.clone(),
            model: self.model.bounds(model),
        };
        ZonotopeDesign::new(observer, bounds, self.columns.unwrap_or(10 * model.nx().max(1)))
    }
}
