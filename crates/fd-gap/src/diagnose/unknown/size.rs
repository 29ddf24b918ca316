//! How strong the disturbances and the noise beside an explanation are.

use std::{ops::Range, sync::Arc};

use faer::{
    Mat, Side,
    linalg::solvers::{Llt, Solve},
};
use fd_effect::SiteRef;
use fd_sim::{model::Model, simulate::Nominal};

use super::responses::{Disturbance, Disturbed};
use crate::{
    fit::{LeastSquares, Log, Minimum, Problem, Search, Unknown, Weights, minimise},
    shrink::FREE_RUN_SHARE,
};

/// Places that disturbances act at together.
const PLACES: usize = 3;
/// Evidence that a further place must gain, in nats.
const WORTH_A_PLACE: f64 = 3.0;
/// Rounds in which the sizes of the noise and of the disturbances settle.
const ROUNDS: usize = 4;
/// Standard deviations of a disturbance that are tried, in those whose constant response is once the noise: powers of two.
const POWERS: [i32; 2] = [-6, 14];
/// Precision of an unknown that is exact.
const EXACT: f64 = 1e12;
/// Precision of an unknown that has no prior.
const FLAT: f64 = 1e-6;

/// What is unknown beside an explanation.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Beside {
    /// The noise and what the disturbances add to it.
    pub(in crate::diagnose) weights: Weights,
    /// Where they act, with the root of their intensity, in the unit of the place and samples.
    pub(in crate::diagnose) places: Vec<(SiteRef, f64)>,
}

/// What is unknown beside a fitted problem at `z`, of which `model` is the settled model, where the noise is `sigma` or
/// stronger; `None` when it cannot be simulated.
pub(in crate::diagnose) fn beside(
    nominal: &dyn Nominal,
    model: &Model,
    problem: &Problem,
    z: &[f64],
    sigma: &[f64],
) -> Option<Beside> {
    let mut problem = problem.clone();
    problem.set_weights(Weights::white(sigma.to_vec()));
    let look = Search { iterations: 0, ..Search::PLAIN };
    let at = minimise(&mut problem, z, None, look)?;
    let disturbed = Disturbed::fitted(nominal, model, &problem, z);
    let disturbances = disturbed.disturbances();
    let regression = Regression::new(&problem, &at, &disturbances);
    let (noise, sizes) = regression.sized()?;
    let sized: Vec<(Disturbance, f64)> =
        disturbances.into_iter().zip(sizes).filter(|(_, size)| 0.0 < *size).collect();
    let unknown = covariance(&sized, &noise, disturbed.rows())?;
    let places = sized.into_iter().map(|(d, size)| (d.site, size * d.unit)).collect();
    let sigma = sigma.iter().zip(&noise).map(|(sigma, noise)| sigma * noise).collect();
    let weights = Weights { unknown: Some(Arc::new(unknown)), ..Weights::white(sigma) };
    Some(Beside { weights, places })
}

/// What disturbances of these sizes add to noise of this strength.
fn covariance(
    sized: &[(Disturbance, f64)],
    noise: &[f64],
    rows: &[Range<usize>],
) -> Option<Unknown> {
    let mut columns = Vec::new();
    for (disturbance, size) in sized {
        for column in &disturbance.columns {
            let mut column = column.clone();
            for rows in rows {
                let length = rows.len() / noise.len();
                for (i, value) in column[rows.clone()].iter_mut().enumerate() {
                    *value *= size / noise[i / length];
                }
            }
            columns.push(column);
        }
    }
    Unknown::new(&columns, rows)
}

impl Beside {
    /// The same for forecasts of other logs by this model.
    pub(in crate::diagnose) fn of_forecasts(
        &self,
        nominal: &dyn Nominal,
        model: &Model,
        problem: &Problem,
        logs: &[Log],
    ) -> Option<Forecasts> {
        let mut problem = problem.clone();
        problem.set_weights(Weights::white(self.weights.sigma.clone()));
        let mut logs = logs.to_vec();
        for log in &mut logs {
            // What tells where it begins is not forecast.
            let known = log.samples().div_ceil(FREE_RUN_SHARE) * log.ny;
            log.y[..known].fill(f64::NAN);
        }
        let disturbed = Disturbed::of_logs(nominal, model, &problem, &logs);
        let at = |(site, size): &(SiteRef, f64)| {
            let disturbance = disturbed.at(site)?;
            let size = size / disturbance.unit;
            Some((disturbance, size))
        };
        let sized = self.places.iter().map(at).collect::<Option<Vec<_>>>()?;
        let ones = vec![1.0; self.weights.sigma.len()];
        let unknown = covariance(&sized, &ones, disturbed.rows())?;
        Some(Forecasts { sigma: self.weights.sigma.clone(), unknown })
    }
}

/// The noise of forecasts of some logs, and what is unknown beside it.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Forecasts {
    pub(in crate::diagnose) sigma: Vec<f64>,
    unknown: Unknown,
}

impl Forecasts {
    /// Logarithm of the density of forecast errors in sigma: outputs, logs, samples.
    pub(in crate::diagnose) fn log_density(&self, errors: &[Vec<Vec<f64>>]) -> f64 {
        let logs = errors.first().map_or(0, Vec::len);
        let mut log = -0.5 * self.unknown.log_determinant();
        for l in 0..logs {
            let all = errors.iter().flat_map(|signals| &signals[l]);
            let mut r: Vec<f64> = all.map(|e| if e.is_finite() { *e } else { 0.0 }).collect();
            self.unknown.whiten(l, &mut r);
            log -= 0.5 * r.iter().map(|r| r * r).sum::<f64>();
        }
        for (signals, sigma) in errors.iter().zip(&self.sigma) {
            let samples = signals.iter().flatten().filter(|e| e.is_finite()).count();
            log -= samples as f64 * sigma.ln();
        }
        log
    }
}

/// `r = N z + W f + e` with independent Gaussian `z`, `f` and `e`: products of its columns, output by output.
struct Regression {
    /// Columns of the unknowns of the fit, with their precisions.
    precisions: Vec<f64>,
    /// The columns of each disturbance.
    places: Vec<Range<usize>>,
    outputs: Vec<Products>,
}

/// Of one output.
struct Products {
    gram: Mat<f64>,
    right: Vec<f64>,
    squares: f64,
    samples: f64,
}

/// The most probable unknowns for given sizes.
struct Solution {
    /// Columns that take part, with their precisions.
    chosen: Vec<usize>,
    precisions: Vec<f64>,
    factor: Llt<f64>,
    solution: Mat<f64>,
    log_evidence: f64,
}

impl Regression {
    fn new(problem: &Problem, at: &Minimum, disturbances: &[Disturbance]) -> Self {
        let layout = problem.layout();
        let ny = problem.weights().sigma.len();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut precisions = Vec::new();
        let precision = |i: usize| {
            let [low, high] = problem.bounds()[i];
            let prior = problem.prior()[i][1];
            match prior {
                _ if high <= low => EXACT,
                prior if 0.0 < prior => prior,
                _ if (high - low).is_finite() => 12.0 / (high - low).powi(2),
                _ => FLAT,
            }
        };
        for (i, slope) in at.slopes.iter().enumerate() {
            if i < layout.shared {
                columns.push(slope.to_vec());
                precisions.push(precision(i));
                continue;
            }
            for (s, rows) in layout.segments.iter().enumerate() {
                let mut column = vec![0.0; slope.len()];
                column[rows.clone()].copy_from_slice(&slope[rows.clone()]);
                columns.push(column);
                precisions.push(precision(layout.first_own(s) + i - layout.shared));
            }
        }
        let mut places = Vec::new();
        for disturbance in disturbances {
            let first = columns.len();
            columns.extend(disturbance.columns.iter().cloned());
            places.push(first..columns.len());
        }
        let plan = problem.plan();
        let outputs = (0..ny).map(|c| {
            let own: Vec<usize> = layout
                .segments
                .iter()
                .flat_map(|rows| {
                    let length = rows.len() / ny;
                    rows.start + c * length..rows.start + (c + 1) * length
                })
                .collect();
            let w = Mat::from_fn(own.len(), columns.len(), |i, j| columns[j][own[i]]);
            let r: Vec<f64> = own.iter().map(|i| at.r[*i]).collect();
            let right =
                (0..columns.len()).map(|j| w.col(j).iter().zip(&r).map(|(w, r)| w * r).sum());
            let right = right.collect();
            let each = plan.logs.iter().flat_map(|log| log.y.iter().skip(c).step_by(log.ny));
            Products {
                gram: w.transpose() * &w,
                right,
                squares: r.iter().map(|r| r * r).sum(),
                samples: each.filter(|y| y.is_finite()).count() as f64,
            }
        });
        let outputs = outputs.collect();
        Self { precisions, places, outputs }
    }

    /// The normal equations for the noise of each output and the size of the disturbance at each place, zero where there is
    /// none; `None` when they are singular.
    fn solve(&self, noise: &[f64], sizes: &[f64]) -> Option<Solution> {
        let mut chosen: Vec<usize> = (0..self.precisions.len()).collect();
        let mut precisions = self.precisions.clone();
        for (place, size) in self.places.iter().zip(sizes).filter(|(_, size)| 0.0 < **size) {
            chosen.extend(place.clone());
            precisions.extend(place.clone().map(|_| size.powi(-2)));
        }
        let m = chosen.len();
        let weights: Vec<f64> = noise.iter().map(|noise| noise.powi(-2)).collect();
        let sum = |of: &dyn Fn(&Products) -> f64| -> f64 {
            self.outputs.iter().zip(&weights).map(|(output, weight)| weight * of(output)).sum()
        };
        let mut a = Mat::<f64>::zeros(m, m);
        for (output, weight) in self.outputs.iter().zip(&weights) {
            for j in 0..m {
                for i in j..m {
                    a[(i, j)] += weight * output.gram[(chosen[i], chosen[j])];
                }
            }
        }
        for (i, precision) in precisions.iter().enumerate() {
            a[(i, i)] += precision;
        }
        let b = Mat::from_fn(m, 1, |i, _| sum(&|o| o.right[chosen[i]]));
        let factor = a.llt(Side::Lower).ok()?;
        let solution = factor.solve(&b);
        let explained: f64 = (0..m).map(|i| b[(i, 0)] * solution[(i, 0)]).sum();
        let l = factor.L();
        let determinant: f64 = (0..m).map(|i| 2.0 * l[(i, i)].ln()).sum();
        let priors: f64 = precisions.iter().map(|precision| precision.ln()).sum();
        let noises: f64 =
            self.outputs.iter().zip(noise).map(|(output, noise)| output.samples * noise.ln()).sum();
        let log_evidence =
            0.5 * (explained - sum(&|o| o.squares) - determinant + priors) - noises;
        Some(Solution { chosen, precisions, factor, solution, log_evidence })
    }

    /// The noise of each output that fits what a solution leaves.
    fn noise(&self, at: &Solution) -> Vec<f64> {
        let Solution { chosen, precisions, factor, solution, .. } = at;
        let m = chosen.len();
        // Unknowns that the data decide take samples from what is left.
        let inverse = factor.solve(&Mat::<f64>::identity(m, m));
        let decided: f64 = (0..m).map(|i| 1.0 - precisions[i] * inverse[(i, i)]).sum();
        let all: f64 = self.outputs.iter().map(|output| output.samples).sum();
        let of = |output: &Products| {
            let mut squares = output.squares;
            for i in 0..m {
                let along: f64 =
                    (0..m).map(|j| output.gram[(chosen[i], chosen[j])] * solution[(j, 0)]).sum();
                squares += solution[(i, 0)] * (along - 2.0 * output.right[chosen[i]]);
            }
            let samples = output.samples * (1.0 - decided / all).max(0.1);
            (squares.max(0.0) / samples.max(1.0)).sqrt().max(1.0)
        };
        self.outputs.iter().map(of).collect()
    }

    /// The noise of each output and the size of the disturbance at each place that have the most evidence.
    fn sized(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut noise = vec![1.0; self.outputs.len()];
        let mut sizes = vec![0.0; self.places.len()];
        for _ in 0..ROUNDS {
            sizes = self.sizes(&noise, &sizes)?;
            let found = self.noise(&self.solve(&noise, &sizes)?);
            // Measured against the noise as it was.
            noise = found;
        }
        Some((noise, sizes))
    }

    /// Sizes with the most evidence, from known ones on: places are added while they are worth it.
    fn sizes(&self, noise: &[f64], known: &[f64]) -> Option<Vec<f64>> {
        let mut best = known.to_vec();
        let mut most = self.solve(noise, &best)?.log_evidence;
        loop {
            let before = most;
            let count = best.iter().filter(|size| 0.0 < **size).count();
            let start = best.clone();
            for place in 0..best.len() {
                let is_new = start[place] <= 0.0;
                if is_new && PLACES <= count {
                    continue;
                }
                for power in POWERS[0]..=POWERS[1] {
                    let mut tried = start.clone();
                    tried[place] = 2.0_f64.powi(power);
                    let Some(found) = self.solve(noise, &tried) else { continue };
                    let price = if is_new { WORTH_A_PLACE } else { 0.0 };
                    if most + price < found.log_evidence {
                        (best, most) = (tried, found.log_evidence);
                    }
                }
            }
            if most <= before + 0.1 {
                return Some(best);
            }
        }
    }
}
