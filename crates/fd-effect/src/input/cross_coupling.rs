//! Cross-coupling of actuators.

use fd_sim::{equation::Expr, model::Model, scales::ReplayScales};

use crate::{Effect, Offers, Reason, SiteRef, Sketch, dynamics::mentions, units::per};

/// A share of another input arrives too: `u_i + c u_j`.
#[derive(Clone, Copy, Debug)]
pub struct InputCrossCoupling;

impl Effect for InputCrossCoupling {
    fn label(&self) -> &'static str {
        "input-cross-coupling"
    }

    fn family(&self) -> &'static str {
        "coupling"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let mut offers = Vec::new();
        for (i, input) in scales.inputs.iter().enumerate() {
            let sketch = || Sketch::of_input(self, "linear", nominal, scales, i);
            let others = scales.inputs.iter().enumerate().filter(|(j, _)| *j != i);
            offers.extend(others.map(|(j, other)| {
                let unit = per(&input.unit, &other.unit);
                let scale = input.std / other.std;
                sketch()
                    .require(input.moves() && other.moves(), super::places::STILL)
                    .require(mentions(nominal, &nominal.inputs[i].name), Reason::Idle)
                    .partner(SiteRef::Input(j, other.name.clone()))
                    .bind("w", Expr::name(&other.name))
                    .strength("c", &format!("from_{}", other.name), unit, scale, [-3.0, 3.0])
                    .wrap_input("u + c*w")
                    .starts([[0.1]])
                    .finish()
            }));
            if scales.inputs.len() == 1 {
                offers.push(sketch().require(false, Reason::Alone("input")).finish());
            }
        }
        offers
    }
}
