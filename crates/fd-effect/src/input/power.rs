//! An actuator whose effect grows with a power of the command.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_place;
use crate::{Effect, Offers, units::per};

/// A power law, as of the thrust of a propeller or the flow through a throttle, with the sign of the command: the plant sees
/// `(1 + e) u + b u |u|` (`square`) or `(1 + e) u |u/U|^n` (`power`), with `U` the largest command of the log.
#[derive(Clone, Copy, Debug)]
pub struct InputPower;

impl Effect for InputPower {
    fn label(&self) -> &'static str {
        "input-power"
    }

    fn family(&self) -> &'static str {
        "actuator-nonlinearity"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_place(self, nominal, scales, |sketch, input| {
            let peak = input.peak();
            vec![
                sketch("square")
                    .strength("b", "square", per("1", &input.unit), 1.0 / peak, [-3.0, 10.0])
                    .strength("e", "power_gain", "1", 1.0, [-1.0, 2.0])
                    .wrap_input("(1 + e)*u + b*u*abs(u)")
                    .starts([[0.1, -0.05], [0.5, -0.4], [-0.1, 0.05]]),
                sketch("power")
                    .strength("n", "power", "1", 1.0, [-0.9, 3.0])
                    .strength("e", "power_gain", "1", 1.0, [-1.0, 2.0])
                    .bind("U", peak)
                    // Below 1e-9 the power is lost in rounding, and its slope stays finite.
                    .wrap_input("(1 + e)*u*max(abs(u)/U, 1e-9)^n")
                    .starts([[0.1, 0.05], [0.8, 0.2], [-0.3, -0.1]]),
            ]
        })
    }
}
