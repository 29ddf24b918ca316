//! A parameter that wanders.

use fd_sim::{model::Model, scales::ReplayScales};

use super::parameter::is_used;
use crate::{
    Effect, InAnotherRun, Offers, Reason, Sketch,
    map::{curve, curve_of, one_hat},
};

/// Knots of the finer way.
const FINE: u8 = 16;
/// Error at a knot, relative to the parameter, that is a scale of the fit.
const SCALE: f64 = 0.2;

/// A parameter that changes in the course of the log, `p (1 + c(t))`: `c` is drawn by straight lines between six or
/// sixteen knots, as slow as a leak that opens, a tool that wears, a room that warms up. Beyond the log it stays as it is.
///
/// *When not to use:* for what jumps, and on logs whose held-out part is another run: the path is that of one log.
#[derive(Clone, Copy, Debug)]
pub struct ParameterWander;

impl Effect for ParameterWander {
    fn label(&self) -> &'static str {
        "parameter-wander"
    }

    fn family(&self) -> &'static str {
        "parameter"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn has_slope(&self) -> bool {
        false
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let range = [0.0, scales.duration];
        let offers = nominal.parameters.iter().enumerate().flat_map(|(i, parameter)| {
            let wanders = |law| {
                Sketch::of_parameter(self, law, nominal, scales, i)
                    // A black box takes its parameters when it starts.
                    .require(!scales.states.is_empty(), Reason::Missing("state"))
                    .require(parameter.tolerance > 0.0, Reason::Exact)
                    .require(is_used(nominal, parameter), Reason::Unused)
            };
            // Finer where the first way is not enough: one bump is all that is looked for before the fit.
            let bump = one_hat(FINE, FINE / 2);
            [
                curve(wanders("six-pieces"), "1", SCALE, "t", range),
                curve_of(FINE, wanders("sixteen-pieces"), "1", SCALE, "t", range).start(&bump),
            ]
            .map(|sketch| {
                sketch.wrap_parameter("p*(1 + curve)").in_another_run(InAnotherRun::Path).finish()
            })
        });
        offers.collect()
    }
}
