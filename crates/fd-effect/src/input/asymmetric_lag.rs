//! An actuator that is slower in one direction than in the other.

use fd_sim::{model::Model, scales::ReplayScales};

use super::{
    LONGEST,
    places::{each_input, either_way},
};
use crate::{Effect, Offers};

/// A lag of order 1 with the time constant `T (1 + a)` upwards and `T (1 - a)` downwards: what heats faster than it cools, a
/// valve with a spring. A run starts at rest. The response to the held input is exact, as it goes one way in a step, and the
/// plant sees its mean over the integration step.
///
/// A cause of its own, as no symmetric lag is near to it.
#[derive(Clone, Copy, Debug)]
pub struct InputAsymmetricLag;

impl Effect for InputAsymmetricLag {
    fn label(&self) -> &'static str {
        "input-asymmetric-lag"
    }

    fn family(&self) -> &'static str {
        "actuator-dynamics"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let longest = LONGEST.min(0.5 * scales.duration / scales.ts);
        each_input(self, nominal, scales, |sketch, input| {
            vec![
                sketch("order-1")
                    .strength("T", "lag", "s", scales.ts, [0.0, longest])
                    .shape("a", "lag_asymmetry", "1", 1.0, [-0.95, 0.95], 0.5)
                    .memory("b", "lagged", &input.unit, "u")
                    .abbreviate("R", "T*(1 + a*sign(u - b))")
                    // The exponential of -1000 is zero already; the quotient stays finite.
                    .abbreviate("k", "exp(-dt/max(R, dt/1000))")
                    .becomes("b", "u + (b - u)*k")
                    .wrap_input("u + (b - u)*(1 - k)*R/dt")
                    .starts(either_way([4.0, 15.0])),
            ]
        })
    }
}
