//! Effects that change the distribution of a measurement but not the simulation.

use crate::{
    effect::{Effect, Observation, Offers, ReplayScales, Sketch},
    model::Model,
};

/// Values lie on a grid of unknown step: a matter of the lattice of measured values, not of a fit.
#[derive(Clone, Copy, Debug)]
pub struct SensorQuantisation;

/// A share of the samples is far off.
#[derive(Clone, Copy, Debug)]
pub struct SensorOutliers;

/// The noise is stronger than stated.
#[derive(Clone, Copy, Debug)]
pub struct SensorNoise;

impl Effect for SensorQuantisation {
    fn label(&self) -> &'static str {
        "sensor-quantisation"
    }

    fn family(&self) -> &'static str {
        "sensor-noise"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let offers = scales.outputs.iter().enumerate().map(|(i, output)| {
            Sketch::of_output(self, "round", nominal, scales, i)
                .require(output.moves(), super::STILL)
                .strength("q", "quantum", &output.unit, output.std, [0.0, 10.0])
                .observation(Observation::Quantised)
                .starts([[0.01], [0.1]])
                .finish()
        });
        offers.collect()
    }
}

impl Effect for SensorOutliers {
    fn label(&self) -> &'static str {
        "sensor-outliers"
    }

    fn family(&self) -> &'static str {
        "sensor-noise"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let offers = (0..scales.outputs.len()).map(|i| {
            Sketch::of_output(self, "share", nominal, scales, i)
                .strength("p", "outlier_share", "1", 1.0, [0.0, 0.5])
                .observation(Observation::Outliers)
                .starts([[0.02]])
                .finish()
        });
        offers.collect()
    }
}

impl Effect for SensorNoise {
    fn label(&self) -> &'static str {
        "sensor-noise"
    }

    fn family(&self) -> &'static str {
        "sensor-noise"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let offers = scales.outputs.iter().enumerate().map(|(i, output)| {
            let stated = nominal.outputs[i].noise.filter(|noise| *noise > 0.0);
            Sketch::of_output(self, "white", nominal, scales, i)
                .require(stated.is_some() || output.moves(), super::STILL)
                // Beyond what is stated, as the root of the difference of the variances.
                .strength(
                    "s",
                    "extra_noise",
                    &output.unit,
                    stated.unwrap_or(0.01 * output.std),
                    [0.0, 1e3],
                )
                .observation(Observation::Noise)
                .starts([[1.0]])
                .finish()
        });
        offers.collect()
    }
}
