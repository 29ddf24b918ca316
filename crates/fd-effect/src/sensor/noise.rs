//! Effects that change the distribution of a measurement but not the simulation.

use fd_sim::{model::Model, scales::ReplayScales};

use crate::{Effect, Observation, Offers, Sketch};

/// A share of the samples is far off.
#[derive(Clone, Copy, Debug)]
pub struct SensorOutliers;

/// Fewest and most degrees of freedom of heavy tails: fewer have no variance, more no tails.
const FREEDOM: [f64; 2] = [3.0, 10.0];

/// The noise is stronger than stated: white and Gaussian, or with the heavy tails of Student's
/// distribution.
#[derive(Clone, Copy, Debug)]
pub struct SensorNoise;

/// The clock of an output jitters: the error is what the output moves in the time by which that is off.
#[derive(Clone, Copy, Debug)]
pub struct SensorJitter;

impl Effect for SensorJitter {
    fn label(&self) -> &'static str {
        "sensor-jitter"
    }

    fn family(&self) -> &'static str {
        "sensor-noise"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let offers = scales.outputs.iter().enumerate().map(|(i, output)| {
            Sketch::of_output(self, "gaussian", nominal, scales, i)
                .require(output.moves(), super::places::STILL)
                .strength("t", "jitter", "s", nominal.sample_time, [0.0, 10.0])
                .observation(Observation::Jitter)
                .starts([[0.1]])
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
        let laws = [("white", Observation::Noise), ("heavy-tailed", Observation::HeavyTails)];
        let offers = scales.outputs.iter().enumerate().flat_map(|(i, output)| {
            let stated = nominal.outputs[i].noise.filter(|noise| *noise > 0.0);
            laws.map(|(law, observation)| {
                let scale = stated.unwrap_or(0.01 * output.std);
                let sketch = Sketch::of_output(self, law, nominal, scales, i)
                    .require(stated.is_some() || output.moves(), super::places::STILL)
                    // Beyond what is stated, as the root of the difference of the variances.
                    .strength("s", "extra_noise", &output.unit, scale, [0.0, 1e3])
                    .observation(observation);
                let sketch = match observation {
                    Observation::HeavyTails => {
                        let [low, high] = FREEDOM;
                        sketch
                            .shape("n", "degrees_of_freedom", "1", 1.0, FREEDOM, high)
                            .start(&[1.0, low])
                    }
                    _ => sketch.start(&[1.0]),
                };
                sketch.finish()
            })
        });
        offers.collect()
    }
}
