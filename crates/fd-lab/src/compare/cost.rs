//! What an entry costs per sample.

use std::time::Instant;

use fd_core::stage::Stage;
use fd_model::Record;
use fdiag::training::{Trained, TrainingError};

use super::{error::CompareError, named::completed, plants::Ask, scene::Scene};

/// The run is timed this many times; the quickest counts, as everything else is something else's
/// doing.
const TRIES: usize = 7;
/// No further try after so long, in s: what takes seconds is timed well enough.
const LONG: f64 = 1.0;

/// Times per sample on one core, in ns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cost {
    residual: f64,
    detector: f64,
}

impl Cost {
    pub(super) fn total_ns(self) -> f64 {
        self.residual + self.detector
    }
}

impl Scene<'_> {
    /// Times every entry on one engine; none for entries that cannot be built.
    pub(super) fn costs(&self, seed: u64) -> Result<Vec<Option<Cost>>, CompareError> {
        let runs = self.runs(Ask { seed, fresh_runs: 1, tested: false })?;
        let record = &runs.healthy[0];
        let mut costs = Vec::with_capacity(self.config.entries());
        for generator in &self.config.generators {
            let generator = completed(self.config, generator, &runs);
            for bias in &self.config.biases {
                let (generator, spec) = (generator.as_ref().ok(), bias.spec.as_ref());
                let trained = generator.map(|g| runs.train(&self.config.pipeline(g, spec)));
                let trained = trained.and_then(Result::ok);
                let residual = trained.as_ref().and_then(|t| residual_ns(t, record).ok());
                for detector in &self.config.detectors {
                    let both = residual.zip(trained.as_ref()).and_then(|(residual, trained)| {
                        let (primary, star) = trained.calibration();
                        let rows = if bias.spec.is_some() { star } else { primary };
                        let mut detector = trained.scaled(&detector.spec, rows).ok()?;
                        let (nu, channels) =
                            (trained.design().io().nu, trained.design().residual_len());
                        let samples = rows.len() / channels;
                        let detector = quickest(samples, || {
                            detector.reset();
                            let inputs = trained.calibration_inputs().chunks_exact(nu);
                            rows.chunks_exact(channels).zip(inputs).for_each(|(r, u)| {
                                std::hint::black_box(detector.update(u, r));
                            });
                        });
                        Some(Cost { residual, detector })
                    });
                    costs.push(both);
                }
            }
        }
        Ok(costs)
    }
}

fn residual_ns(trained: &Trained, record: &Record) -> Result<f64, TrainingError> {
    let mut pipeline = trained.silent()?;
    Ok(quickest(record.len(), || {
        pipeline.reset();
        for (u, y) in record.samples() {
            // A refused sample costs next to nothing; simulated records have none.
            let _ = std::hint::black_box(pipeline.step(u, y).is_ok());
        }
    }))
}

fn quickest(samples: usize, mut run: impl FnMut()) -> f64 {
    let (mut least, mut total) = (f64::INFINITY, 0.0);
    for _ in 0..TRIES {
        let begun = Instant::now();
        run();
        let time = begun.elapsed().as_secs_f64();
        (least, total) = (least.min(time), total + time);
        if total > LONG {
            break;
        }
    }
    1e9 * least / samples.max(1) as f64
}
