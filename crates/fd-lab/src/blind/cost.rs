//! What it will cost to make cases, before the first is made.

use std::time::{Duration, Instant};

use fd_core::Limits;

use super::{
    draw::draw, error::BlindError, kind::CaseKind, make::Order, oracle::oracle, truth::Scene,
};

/// Samples of a case that is tried.
const TRIED: usize = 200;
/// Nothing is tried for fewer samples in all: they are made as soon.
const FEW: f64 = 20_000.0;
/// Kinds are tried one after the other for so long; the others count as their mean.
const PATIENCE: Duration = Duration::from_secs(3);
/// Memory of a case while it is made, in bytes per sample: logs, runs and their derivatives by parameters.
const SAMPLE_BYTES: f64 = 1000.0;

/// What work will cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Time in s on the threads of the current rayon pool, within a factor of about two.
    pub seconds: f64,
    /// Memory in bytes.
    pub bytes: f64,
}

impl Order {
    /// What it will cost to make the cases, from a few that are tried with few samples: work grows as their number.
    /// No file is written. Takes some seconds, or none where there is little to make.
    ///
    /// # Errors
    ///
    /// As [`Order::check`].
    pub fn cost(&self, limits: &Limits) -> Result<Cost, BlindError> {
        self.check(limits)?;
        let ordered = || self.counts.iter().filter(|(_, count)| 0 < *count);
        let cases: f64 = ordered().map(|(_, count)| *count as f64).sum();
        let threads = rayon::current_num_threads() as f64;
        let bytes = threads.min(cases) * self.samples as f64 * SAMPLE_BYTES;
        if cases * (self.samples as f64) < FEW {
            return Ok(Cost { seconds: 0.0, bytes });
        }
        let samples = self.samples.min(TRIED);
        let (begun, mut work, mut tried) = (Instant::now(), 0.0, 0.0);
        for (kind, count) in ordered() {
            if PATIENCE < begun.elapsed() {
                break;
            }
            // What cannot be drawn with so few samples may be with more.
            if let Ok(seconds) = self.tried(*kind, samples) {
                work += *count as f64 * seconds;
                tried += *count as f64;
            }
        }
        let growth = self.samples as f64 / samples as f64;
        let mean = if tried < 1.0 { 0.0 } else { work / tried };
        Ok(Cost { seconds: mean * cases * growth / threads, bytes })
    }

    /// Time in s for which a case occupies one thread.
    fn tried(&self, kind: CaseKind, samples: usize) -> Result<f64, BlindError> {
        let try_it = || {
            let begun = Instant::now();
            let (truth, model) = draw(self.seed, kind, 0, samples)?;
            oracle(&Scene::new(&truth, &model)?, self.full_oracle)?;
            Ok(begun.elapsed().as_secs_f64())
        };
        // A case shares its work among all threads; here there is to be one.
        match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
            Ok(alone) => alone.install(try_it),
            Err(_) => try_it(),
        }
    }
}
