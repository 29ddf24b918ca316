//! Cross-talk between sensors.

use fd_sim::{model::Model, scales::ReplayScales};

use crate::{Effect, Offers, Reason, SiteRef, Sketch, units::per};

/// A share of what another sensor measures is added, `y_i + c (y_j - mean)`, with the mean of the
/// nominal model: a temperature in kelvin is not taken for a bias.
#[derive(Clone, Copy, Debug)]
pub struct SensorCrossTalk;

impl Effect for SensorCrossTalk {
    fn label(&self) -> &'static str {
        "sensor-cross-talk"
    }

    fn family(&self) -> &'static str {
        "coupling"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let mut offers = Vec::new();
        for (i, output) in scales.outputs.iter().enumerate() {
            let sketch = || Sketch::of_output(self, "linear", nominal, scales, i);
            let others = scales.outputs.iter().enumerate().filter(|(j, _)| *j != i);
            offers.extend(others.map(|(j, other)| {
                let unit = per(&output.unit, &other.unit);
                let scale = output.std / other.std;
                sketch()
                    .require(output.moves() && other.moves(), super::STILL)
                    .partner(SiteRef::Output(j, other.name.clone()))
                    .bind("w", nominal.outputs[j].value.clone())
                    .bind("W", other.mean)
                    .strength("c", &format!("from_{}", other.name), unit, scale, [-3.0, 3.0])
                    .wrap_output("y + c*(w - W)")
                    .starts([[0.1]])
                    .finish()
            }));
            if scales.outputs.len() == 1 {
                offers.push(sketch().require(false, Reason::Alone("output")).finish());
            }
        }
        offers
    }
}
