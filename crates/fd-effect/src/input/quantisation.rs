//! Quantisation of a command.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_input;
use crate::{Effect, Offers, Rounding};

/// Fewest and most eighths of a quantum per peak of the input from which to start: some quantum is
/// never more than a sixteenth of a step off at the peak, where the response to a wrong one is lost.
const EIGHTHS: [u16; 2] = [12, 64];

/// The command is rounded to multiples of `q`: to the nearest, towards zero, or downwards. Outputs are
/// not smooth in `q`: search, do not differentiate.
#[derive(Clone, Copy, Debug)]
pub struct InputQuantisation;

impl Effect for InputQuantisation {
    fn label(&self) -> &'static str {
        "input-quantisation"
    }

    fn family(&self) -> &'static str {
        "actuator-nonlinearity"
    }

    fn has_slope(&self) -> bool {
        false
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_input(self, nominal, scales, |sketch, input| {
            let law = |name, rounding, template| {
                sketch(name)
                    .strength("q", "quantum", &input.unit, input.peak(), [0.0, 1.0])
                    .bind("Q", 1e-9 * input.peak())
                    .wrap_input(template)
                    .starts(quanta().map(|quantum| [quantum]))
                    .rounding(rounding)
            };
            let nearest = "if(q > Q, q*floor(u/max(q, Q) + 0.5), u)";
            let towards_zero = "if(q > Q, q*sign(u)*floor(abs(u)/max(q, Q)), u)";
            let downwards = "if(q > Q, q*floor(u/max(q, Q)), u)";
            vec![
                law("round", Rounding::Nearest, nearest),
                law("towards-zero", Rounding::TowardsZero, towards_zero),
                law("downwards", Rounding::Downwards, downwards),
            ]
        })
    }
}

fn quanta() -> impl Iterator<Item = f64> {
    let [coarsest, finest] = EIGHTHS;
    (coarsest..=finest).map(|eighths| 8.0 / f64::from(eighths))
}
