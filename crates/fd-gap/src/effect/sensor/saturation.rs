//! Saturation of a sensor.

use super::each_output;
use crate::{
    effect::{Effect, Offers, ReplayScales, units::per},
    model::Model,
};

/// Saturation at a distance of `1/s` from the middle `c` of the range that the nominal model
/// shows: the strength is the inverse of the distance, so that none is exactly none. At both ends,
/// or at one.
#[derive(Clone, Copy, Debug)]
pub struct SensorSaturation;

impl Effect for SensorSaturation {
    fn label(&self) -> &'static str {
        "sensor-saturation"
    }

    fn family(&self) -> &'static str {
        "sensor-nonlinearity"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_output(self, nominal, scales, |sketch, output| {
            let half = 0.5 * (output.high - output.low);
            let limit = |law, excess| {
                sketch(law)
                    .limit("s", "limit", per("1", &output.unit), 1.0 / half, [0.0, 12.5])
                    .bind("c", output.low + half)
                    .abbreviate("d", "y - c")
                    .abbreviate("q", excess)
                    // What is cut off is exactly zero for s = 0.
                    .wrap_output("y - (q - q/max(1, s*abs(q)))")
                    .starts([0.985, 0.96, 0.92, 0.8, 0.62, 0.42].map(|level| [1.0 / level]))
            };
            vec![limit("both", "d"), limit("upper", "max(d, 0)"), limit("lower", "min(d, 0)")]
        })
    }
}
