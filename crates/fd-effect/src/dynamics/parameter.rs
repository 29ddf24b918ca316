//! A parameter that is further off than its tolerance.

use fd_sim::{
    equation::Expr,
    model::{Draft, Model, Parameter},
    scales::ReplayScales,
};

use crate::{Effect, Offers, Reason, Sketch};

/// Relative error `p (1 + e)` of a named parameter; not of one that is said to be exact, nor of one
/// that only the controller uses.
#[derive(Clone, Copy, Debug)]
pub struct ParameterError;

impl Effect for ParameterError {
    fn label(&self) -> &'static str {
        "parameter-error"
    }

    fn family(&self) -> &'static str {
        "parameter"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let offers = nominal.parameters.iter().enumerate().map(|(i, parameter)| {
            Sketch::of_parameter(self, "relative", nominal, scales, i)
                .require(parameter.tolerance > 0.0, Reason::Exact)
                .require(is_used(nominal, parameter), Reason::Unused)
                .strength("e", "error", "1", 1.0, bounds(parameter))
                .wrap_parameter("p*(1 + e)")
                .starts([[0.05], [0.4], [-0.3]])
                .finish()
        });
        offers.collect()
    }
}

pub(super) fn is_used(model: &Model, parameter: &Parameter) -> bool {
    parameter.value.abs() > 0.0 && mentions(model, &parameter.name)
}

/// Whether an equation of the plant has this name in it.
pub(crate) fn mentions(model: &Model, name: &str) -> bool {
    let mut draft: Draft = model.clone().into_draft();
    draft.plant_expressions_mut().into_iter().any(|expr: &mut Expr| expr.mentions(name))
}

/// What the bounds of the parameter leave of the usual ones; 0 is always within.
fn bounds(parameter: &Parameter) -> [f64; 2] {
    let [low, high] = parameter.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let ends = [low, high].map(|end| end / parameter.value - 1.0);
    let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    [low.clamp(-0.75, 0.0), high.clamp(0.0, 2.5)]
}
