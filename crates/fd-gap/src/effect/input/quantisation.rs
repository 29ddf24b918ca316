//! Quantisation of a command.

use super::each_input;
use crate::{
    effect::{Effect, Offers, ReplayScales},
    model::Model,
};

/// Fewest and most eighths of a quantum per peak of the input that are tried: some quantum is never
/// more than a sixteenth of a step off at the peak, where the response to a wrong one is lost.
const EIGHTHS: [u16; 2] = [12, 480];

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
                    .starts(quanta().map(|quantum| [quantum]))
                    .rough(),
            ]
        })
    }
}

fn quanta() -> impl Iterator<Item = f64> {
    let [coarsest, finest] = EIGHTHS;
    (coarsest..=finest).map(|eighths| 8.0 / f64::from(eighths))
}
