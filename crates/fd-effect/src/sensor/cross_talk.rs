//! Cross-talk between sensors.

use fd_sim::{model::Model, scales::ReplayScales};

use crate::{Effect, Offers, Reason, SiteRef, Sketch, units::per};

/// A share of what another sensor measures is added: `linear`, `y_i + c (y_j - mean)`, with the mean of the
/// nominal model, as of a sensor that was zeroed in operation (a temperature in kelvin is not taken for a
/// bias), or `with-mean`, `y_i + c y_j`.
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
            let sketch = |law| Sketch::of_output(self, law, nominal, scales, i);
            let others = scales.outputs.iter().enumerate().filter(|(j, _)| *j != i);
            let laws = [("linear", "y + c*(w - W)"), ("with-mean", "y + c*w")];
            let all = others.flat_map(|other| laws.map(|law| (other, law)));
            offers.extend(all.map(|((j, other), (law, template))| {
                let unit = per(&output.unit, &other.unit);
                let scale = output.std / other.std;
                sketch(law)
                    .require(output.moves() && other.moves(), super::places::STILL)
                    .partner(SiteRef::Output(j, other.name.clone()))
                    .bind("w", nominal.outputs[j].value.clone())
                    .bind("W", other.mean)
                    .strength("c", &format!("from_{}", other.name), unit, scale, [-3.0, 3.0])
                    .wrap_output(template)
                    .starts([[0.1]])
                    .finish()
            }));
            if scales.outputs.len() == 1 {
                offers.push(sketch("linear").require(false, Reason::Alone("output")).finish());
            }
        }
        offers
    }
}
