//! Quantisation of a command.

use super::each_input;
use crate::{
    effect::{Effect, Offers, ReplayScales},
    model::Model,
};

/// The command is rounded to multiples of `q`. Outputs are not smooth in `q`: search, do not
/// differentiate.
#[derive(Clone, Copy, Debug)]
pub struct InputQuantisation;

impl Effect for InputQuantisation {
    fn label(&self) -> &'static str {
        "input-quantisation"
    }

    fn family(&self) -> &'static str {
        "actuator-nonlinearity"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_input(self, nominal, scales, |sketch, input| {
            vec![
                sketch("round")
                    .strength("q", "quantum", &input.unit, input.peak(), [0.0, 1.0])
                    .bind("Q", 1e-9 * input.peak())
                    .wrap_input("if(q > Q, q*floor(u/max(q, Q) + 0.5), u)")
                    .starts([[0.3], [0.1], [0.03], [0.01]]),
            ]
        })
    }
}
