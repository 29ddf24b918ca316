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
    shrink::Forecast,
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
    /// Where they act.
    pub(in crate::diagnose) places: Vec<SiteRef>,
}

/// What is unknown beside a fitted problem at `z`, of which `model` is the settled model, where the noise is that of its
/// weights or stronger. Disturbances act at these places, or anywhere. `None` when the problem cannot be simulated.
pub(in crate::diagnose) fn beside(
    nominal: &dyn Nominal,
    model: &Model,
    problem: &Problem,
    z: &[f64],
    places: Option<&[SiteRef]>,
) -> Option<Beside> {
    let mut problem = problem.clone();
    let white = Weights::white(problem.weights().sigma.clone());
    problem.set_weights(white.clone());
    let look = Search { iterations: 0, ..Search::PLAIN };
    let at = minimise(&mut problem, z, None, look)?;
    let disturbed = Disturbed::fitted(nominal, model, &problem, z);
    let disturbances = match places {
        Some(places) => places.iter().filter_map(|site| disturbed.at(site)).collect(),
        None => disturbed.disturbances(),
    };
    let (noise, sizes, _) = sized(&[Regression::of(&problem, &at, &disturbances)])?;
    let sized: Vec<(Disturbance, f64)> =
        disturbances.into_iter().zip(sizes).filter(|(_, size)| 0.0 < *size).collect();
    let unknown = covariance(&sized, &noise, disturbed.rows())?;
    let places = sized.into_iter().map(|(d, _)| d.site).collect();
    let weights = Weights { unknown: Some(Arc::new(unknown)), ..white };
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
    Unknown::new(noise.to_vec(), &columns, rows)
}

impl Beside {
    /// Logarithm of the density of a forecast of other `logs` by a settled `model`, in units of the noise of its `problem`;
    /// `None` when it cannot be simulated there. Disturbances act at the same places. How strong they and the noise are
    /// there is decided by the errors: another run excites other parts of what is unknown.
    pub(in crate::diagnose) fn log_density(
        &self,
        nominal: &dyn Nominal,
        model: &Model,
        problem: &Problem,
        logs: &[Log],
        forecast: &Forecast,
    ) -> Option<f64> {
        let disturbed = Disturbed::forecast(nominal, model, problem, logs, forecast);
        let places = self.places.iter().map(|site| disturbed.at(site));
        let disturbances = places.collect::<Option<Vec<_>>>()?;
        let each = (0..forecast.segments.len())
            .flat_map(|s| forecast.errors.iter().flat_map(move |signals| &signals[s]));
        let r: Vec<f64> = each.map(|e| if e.is_finite() { *e } else { 0.0 }).collect();
        // Nothing is common to the segments but how strong disturbances are.
        let parts = disturbed.rows().iter().enumerate().map(|(s, rows)| {
            let count =
                |signals: &Vec<Vec<f64>>| signals[s].iter().filter(|e| e.is_finite()).count();
            let samples: Vec<f64> =
                forecast.errors.iter().map(|signals| count(signals) as f64).collect();
            let within = disturbances.iter().map(|d| d.within(rows)).collect::<Vec<_>>();
            let whole = std::iter::once(0..rows.len()).collect::<Vec<_>>();
            Regression::new(&r[rows.clone()], Vec::new(), &within, &whole, &samples)
        });
        let (.., log_evidence) = sized(&parts.collect::<Vec<_>>())?;
        Some(log_evidence)
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
    unknowns: Mat<f64>,
    log_evidence: f64,
}

impl Regression {
    /// Of a problem, with its unknowns.
    fn of(problem: &Problem, at: &Minimum, disturbances: &[Disturbance]) -> Self {
        let layout = problem.layout();
        let ny = problem.weights().sigma.len();
        let mut unknowns = Vec::new();
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
                unknowns.push((slope.to_vec(), precision(i)));
                continue;
            }
            for (s, rows) in layout.segments.iter().enumerate() {
                let mut column = vec![0.0; slope.len()];
                column[rows.clone()].copy_from_slice(&slope[rows.clone()]);
                unknowns.push((column, precision(layout.first_own(s) + i - layout.shared)));
            }
        }
        let plan = problem.plan();
        let samples = (0..ny).map(|c| {
            let each = plan.logs.iter().flat_map(|log| log.y.iter().skip(c).step_by(log.ny));
            each.filter(|y| y.is_finite()).count() as f64
        });
        let samples: Vec<f64> = samples.collect();
        Self::new(&at.r, unknowns, disturbances, &layout.segments, &samples)
    }

    /// Of residuals (output by output within each segment), columns of unknowns with their precisions, and so many
    /// samples of each output.
    fn new(
        r: &[f64],
        unknowns: Vec<(Vec<f64>, f64)>,
        disturbances: &[Disturbance],
        segments: &[Range<usize>],
        samples: &[f64],
    ) -> Self {
        let (mut columns, precisions): (Vec<_>, Vec<_>) = unknowns.into_iter().unzip();
        let mut places = Vec::new();
        for disturbance in disturbances {
            let first = columns.len();
            columns.extend(disturbance.columns.iter().cloned());
            places.push(first..columns.len());
        }
        let ny = samples.len();
        let outputs = samples.iter().enumerate().map(|(c, samples)| {
            let of_segment = |rows: &Range<usize>| {
                let length = rows.len() / ny;
                rows.start + c * length..rows.start + (c + 1) * length
            };
            let own: Vec<usize> = segments.iter().flat_map(of_segment).collect();
            let w = Mat::from_fn(own.len(), columns.len(), |i, j| columns[j][own[i]]);
            let r = Mat::from_fn(own.len(), 1, |i, _| r[own[i]]);
            let right = w.transpose() * &r;
            Products {
                gram: w.transpose() * &w,
                right: (0..columns.len()).map(|j| right[(j, 0)]).collect(),
                squares: r.squared_norm_l2(),
                samples: *samples,
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
        let unknowns = factor.solve(&b);
        let explained: f64 = (0..m).map(|i| b[(i, 0)] * unknowns[(i, 0)]).sum();
        let l = factor.L();
        let determinant: f64 = (0..m).map(|i| 2.0 * l[(i, i)].ln()).sum();
        let priors: f64 = precisions.iter().map(|precision| precision.ln()).sum();
        let noises: f64 =
            self.outputs.iter().zip(noise).map(|(output, noise)| output.samples * noise.ln()).sum();
        let log_evidence = 0.5 * (explained - sum(&|o| o.squares) - determinant + priors) - noises;
        Some(Solution { chosen, precisions, factor, unknowns, log_evidence })
    }

    /// What a solution leaves of the squares of each output, and the number of unknowns that the data decide.
    fn left(&self, at: &Solution) -> (Vec<f64>, f64) {
        let Solution { chosen, precisions, factor, unknowns, .. } = at;
        let m = chosen.len();
        let inverse = factor.solve(&Mat::<f64>::identity(m, m));
        let decided = (0..m).map(|i| 1.0 - precisions[i] * inverse[(i, i)]).sum();
        let of = |output: &Products| {
            let mut squares = output.squares;
            for i in 0..m {
                let along: f64 =
                    (0..m).map(|j| output.gram[(chosen[i], chosen[j])] * unknowns[(j, 0)]).sum();
                squares += unknowns[(i, 0)] * (along - 2.0 * output.right[chosen[i]]);
            }
            squares.max(0.0)
        };
        (self.outputs.iter().map(of).collect(), decided)
    }
}

/// Evidence of independent parts with the same noise and sizes.
fn log_evidence(parts: &[Regression], noise: &[f64], sizes: &[f64]) -> Option<f64> {
    parts.iter().map(|part| Some(part.solve(noise, sizes)?.log_evidence)).sum()
}

/// The noise of each output that fits what is left of it. Unknowns that the data decide take samples from that.
fn noise_of(parts: &[Regression], noise: &[f64], sizes: &[f64]) -> Option<Vec<f64>> {
    let (mut squares, mut samples) = (vec![0.0; noise.len()], vec![0.0; noise.len()]);
    let mut decided = 0.0;
    for part in parts {
        let (left, own) = part.left(&part.solve(noise, sizes)?);
        decided += own;
        squares.iter_mut().zip(left).for_each(|(sum, left)| *sum += left);
        samples.iter_mut().zip(&part.outputs).for_each(|(sum, output)| *sum += output.samples);
    }
    let share = (1.0 - decided / samples.iter().sum::<f64>()).max(0.1);
    let of =
        |(squares, samples): (f64, f64)| (squares / (share * samples).max(1.0)).sqrt().max(1.0);
    Some(squares.into_iter().zip(samples).map(of).collect())
}

/// The noise of each output and the size of the disturbance at each place that have the most evidence, with that.
fn sized(parts: &[Regression]) -> Option<(Vec<f64>, Vec<f64>, f64)> {
    let first = parts.first()?;
    let mut noise = vec![1.0; first.outputs.len()];
    let mut best = vec![0.0; first.places.len()];
    for _ in 0..ROUNDS {
        best = sizes(parts, &noise, &best)?;
        noise = noise_of(parts, &noise, &best)?;
    }
    let log_evidence = log_evidence(parts, &noise, &best)?;
    Some((noise, best, log_evidence))
}

/// Sizes with the most evidence, from known ones on: places are added while they are worth it.
fn sizes(parts: &[Regression], noise: &[f64], known: &[f64]) -> Option<Vec<f64>> {
    let mut best = known.to_vec();
    let mut most = log_evidence(parts, noise, &best)?;
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
                let Some(found) = log_evidence(parts, noise, &tried) else { continue };
                let price = if is_new { WORTH_A_PLACE } else { 0.0 };
                if most + price < found {
                    (best, most) = (tried, found);
                }
            }
        }
        if most <= before + 0.1 {
            return Some(best);
        }
    }
}
