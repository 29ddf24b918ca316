//! A parameter that wanders.

use fd_sim::{model::Model, scales::ReplayScales};

use super::parameter::is_used;
use crate::{Effect, Offers, Reason, Sketch, map::curve};

/// Error at a knot, relative to the parameter, that is a scale of the fit.
const SCALE: f64 = 0.2;

/// A parameter that changes in the course of the log, `p (1 + c(t))`: `c` is drawn by straight lines between six
/// knots, as slow as a leak that opens, a tool that wears, a room that warms up. Beyond the log it stays as it is.
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
        let offers = nominal.parameters.iter().enumerate().map(|(i, parameter)| {
            let sketch = Sketch::of_parameter(self, "of-time", nominal, scales, i)
                .require(parameter.tolerance > 0.0, Reason::Exact)
                .require(is_used(nominal, parameter), Reason::Unused);
            curve(sketch, "1", SCALE, "t", [0.0, scales.duration])
                .wrap_parameter("p*(1 + curve)")
                .finish()
        });
        offers.collect()
    }
}
