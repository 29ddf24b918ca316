//! The fair comparison: the best constant threshold on the whole residual vector.
//!
//! `W r` with a weighting that nobody chose for the fault is a weak opponent. The strongest constant
//! threshold knows which sensor fails and takes the combination `wᵀr` of all residual channels that shows
//! this sensor best next to the healthy runs: it minimises `max |wᵀr|` over them subject to `wᵀφ = 1`, with
//! `φ` the lasting response to a fault of size 1. The compensated vector gets the same freedom.

use faer::{Mat, linalg::solvers::Solve};
use fd_compensate::detect::{DEFAULT_MARGIN, Magnitude};
use fdiag::{
    spec::{DetectorSpec, PipelineSpec},
    training::Trained,
};

use super::{
    benchmark::{Benchmark, Case},
    error::EngineStudyError,
    logs::Logs,
    pair::Pair,
    watch::{Run, Watch},
};

/// Rounds of Lawson's algorithm. The largest magnitude is within some per cent of the least one then, and the
/// best round counts.
const ROUNDS: usize = 30;

impl Benchmark {
    /// Smallest fault of each sensor with the best constant threshold on the residual vector, without and
    /// with compensation.
    pub(super) fn best_thresholds(
        &self,
        case: &Case,
        logs: &Logs,
    ) -> Result<Vec<Pair>, EngineStudyError> {
        let spec = PipelineSpec { weighting: None, ..self.config().pipeline.clone() };
        let unknown = Pair { primary: f64::NAN, compensated: f64::NAN };
        match Self::train(&spec, case, &logs.training, &logs.calibration) {
            Ok(trained) => self.best_thresholds_of(&trained, logs),
            Err(_) => Ok(vec![unknown; self.fault_channels()?.len()]),
        }
    }

    /// The same for any diagnosis of the whole residual vector that has learned from these runs.
    pub(super) fn best_thresholds_of(
        &self,
        trained: &Trained,
        logs: &Logs,
    ) -> Result<Vec<Pair>, EngineStudyError> {
        let channels = self.fault_channels()?;
        let tests = self.tests(trained, &logs.tests)?;
        let (primary, compensated) = trained.calibration();
        let mut pairs = Vec::new();
        for channel in channels {
            let (phi, phi_star) = self.unit_fault_response(trained, channel)?;
            let nu = trained.design().io().nu;
            let smallest = |healthy: &[f64], runs: &[Run], phi: &[f64]| {
                self.smallest_of(
                    healthy,
                    runs,
                    phi,
                    trained.design().residual_len(),
                    nu,
                    tests.start,
                )
            };
            pairs.push(Pair {
                primary: smallest(primary, &tests.primary, &phi)?,
                compensated: smallest(compensated, &tests.compensated, &phi_star)?,
            });
        }
        Ok(pairs)
    }

    fn smallest_of(
        &self,
        healthy: &[f64],
        runs: &[Run],
        phi: &[f64],
        channels: usize,
        nu: usize,
        start: usize,
    ) -> Result<f64, EngineStudyError> {
        let Some(lasting) = phi.rchunks_exact(channels).next() else { return Ok(f64::NAN) };
        let Some(w) = direction(healthy, lasting) else { return Ok(f64::NAN) };
        let project = |rows: &[f64]| -> Vec<f64> {
            rows.chunks_exact(channels).map(|row| along(&w, row)).collect()
        };
        let margin = match self.config().pipeline.detector {
            DetectorSpec::Maximum { margin } => margin,
            _ => DEFAULT_MARGIN,
        };
        let threshold = (1.0 + margin) * peak(&project(healthy));
        let Ok(detector) = Magnitude::<f64>::new(&[1.0], threshold) else { return Ok(f64::NAN) };
        let runs: Vec<Run> = runs
            .iter()
            .map(|run| Run { inputs: run.inputs.clone(), residual: project(&run.residual) })
            .collect();
        let mut watch = Watch::of(Box::new(detector), self.config().pipeline.rule, nu);
        Ok(watch.find(&runs, &project(phi), self.config().faults.size, start)?.smallest)
    }
}

/// `w` with `wᵀφ = 1` that makes the largest `|wᵀr|` of the healthy rows as small as may be, by Lawson's
/// algorithm: least squares again and again, each row weighing in by how large it was left. `None` when the
/// fault does not show or the rows say nothing.
fn direction(healthy: &[f64], phi: &[f64]) -> Option<Vec<f64>> {
    let n = phi.len();
    let rows = || healthy.chunks_exact(n);
    let mut weights = vec![1.0; rows().len()];
    let mut best: Option<(f64, Vec<f64>)> = None;
    for _ in 0..ROUNDS {
        let mut gram = Mat::<f64>::zeros(n, n);
        for (row, weight) in rows().zip(&weights) {
            for (i, a) in row.iter().enumerate() {
                for (j, b) in row.iter().enumerate() {
                    gram[(i, j)] += weight * a * b;
                }
            }
        }
        let trace: f64 = (0..n).map(|i| gram[(i, i)]).sum();
        for i in 0..n {
            // Far below what decides, so that channels that move together leave it regular.
            gram[(i, i)] += 1e-12 * trace;
        }
        let solved = gram.partial_piv_lu().solve(Mat::from_fn(n, 1, |i, _| phi[i]));
        let w: Vec<f64> = (0..n).map(|i| solved[(i, 0)]).collect();
        let gain = along(&w, phi);
        if !(gain.is_finite() && gain > 0.0) {
            break;
        }
        let w: Vec<f64> = w.iter().map(|v| v / gain).collect();
        let left: Vec<f64> = rows().map(|row| along(&w, row).abs()).collect();
        let largest = peak(&left);
        if best.as_ref().is_none_or(|(least, _)| largest < *least) {
            best = Some((largest, w));
        }
        weights.iter_mut().zip(&left).for_each(|(weight, left)| *weight *= left / largest);
    }
    best.map(|(_, w)| w)
}

fn along(w: &[f64], row: &[f64]) -> f64 {
    w.iter().zip(row).map(|(w, r)| w * r).sum()
}

fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two channels with a common disturbance: their difference is nearly free of it.
    #[test]
    fn the_best_direction_beats_every_channel_and_least_squares() {
        let healthy: Vec<f64> = (0..400)
            .flat_map(|k| {
                let (d, e) = ((f64::from(k) * 0.1).sin(), (f64::from(k * k) * 0.618).sin());
                [d + 0.01 * e, d - 0.02 * e * e * e]
            })
            .collect();
        let phi = [1.0, 0.0];
        let w = direction(&healthy, &phi).unwrap_or_default();
        assert!((along(&w, &phi) - 1.0).abs() < 1e-12);
        let left = |w: &[f64]| {
            let rows: Vec<f64> = healthy.chunks_exact(2).map(|row| along(w, row)).collect();
            peak(&rows)
        };
        // Nothing on the line w = (1, w₂) does better by more than a hundredth.
        let best =
            (-2000..2000).map(|i| left(&[1.0, 1e-3 * f64::from(i)])).fold(f64::MAX, f64::min);
        assert!(
            left(&w) < 1.01 * best && left(&w) < 0.1 * left(&[1.0, 0.0]),
            "{} {best}",
            left(&w)
        );
    }

    #[test]
    fn a_fault_that_does_not_show_has_no_direction() {
        assert_eq!(direction(&[1.0, 2.0, 0.5, 1.0], &[0.0, 0.0]), None);
    }
}
