//! Free runs over held-out healthy samples.

use std::sync::atomic::{AtomicBool, Ordering};

use fd_core::stage::BiasModel;
use fd_ident::{
    arx::ArxOrders, hammerstein::HammersteinModel, least_squares::LeastSquares,
    order::select_orders,
};
use fd_model::Record;
use rayon::prelude::*;

use super::candidates::Candidate;
use crate::{
    spec::{LearningSpec, StructureSpec},
    training::{
        bias::LearnedBias,
        error::TrainingError,
        fit::{Search, fit},
        structure::Structure,
    },
};

/// Parts that the samples are dealt into; each is judged by models that have learned from the others.
const FOLDS: usize = 4;
/// Stretches of a part that losses are paired by.
const STRETCHES: usize = 8;
/// Samples beyond which no more are compared on: what is left of a bias is then known to a few per cent.
const MOST_SAMPLES: usize = 20_000;

/// Mean square of `r − μ̂` in each stretch relative to that of `r` over all of them, mean over the channels.
#[derive(Clone, Debug)]
pub(super) struct Losses(Vec<f64>);

impl Losses {
    pub(super) fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    /// Mean difference to another candidate over the same stretches, and its standard error.
    pub(super) fn above(&self, other: &Self) -> (f64, f64) {
        let n = self.0.len() as f64;
        let differences: Vec<f64> = self.0.iter().zip(&other.0).map(|(a, b)| a - b).collect();
        let mean = differences.iter().sum::<f64>() / n;
        let variance =
            differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        (mean, (variance / n).sqrt())
    }
}

/// The healthy samples as parts, and what is common to all candidates.
pub(super) struct Judge<'r> {
    records: &'r [Record],
    parts: Vec<Part>,
    /// Samples at the start of a run that fill the histories of every candidate.
    lag: usize,
    /// Mean square of each channel over the samples that are judged.
    power: Vec<f64>,
}

/// A part of a log.
struct Part {
    /// Of those that are judged together.
    fold: usize,
    /// The log from where it is simulated to the end of the part.
    run: Record,
    /// Where the part begins in it.
    from: usize,
}

impl Part {
    fn own(&self) -> Record {
        self.run.slice(self.from, self.run.len())
    }
}

impl<'r> Judge<'r> {
    /// With as many samples before what is judged as there is room for, up to `lag`, and how many these are: logs that are
    /// too short for long histories choose among shorter ones.
    pub(super) fn of_widest(
        records: &'r [Record],
        lag: usize,
    ) -> Result<(Self, usize), TrainingError> {
        let found = (1..=lag).rev().find_map(|lag| Some((Self::new(records, lag).ok()?, lag)));
        found.map_or_else(|| Ok((Self::new(records, 0)?, 0)), Ok)
    }

    fn new(records: &'r [Record], lag: usize) -> Result<Self, TrainingError> {
        let samples: usize = records.iter().map(Record::len).sum();
        let share = (MOST_SAMPLES as f64 / samples.max(1) as f64).min(1.0);
        let mut parts = Vec::new();
        for (i, record) in records.iter().enumerate() {
            let first = (0..record.len()).find(|&k| record.is_complete(k)).unwrap_or(0);
            let length = (record.len() - first) / FOLDS;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a share of a length"
            )]
            let kept = (share * length as f64).round() as usize;
            for j in 0..FOLDS {
                let from = first + j * length;
                // From where the log begins, as the compensation runs: what a pole near 1 keeps of the first residuals
                // then fades. A part of a log that is not compared as a whole is long enough for that.
                let begin = if kept < length { from } else { first };
                let run = record.slice(begin, from + kept);
                parts.push(Part { fold: (i + j) % FOLDS, run, from: from - begin });
            }
        }
        let mut judge = Self { records, parts, lag, power: Vec::new() };
        let channels = records[0].outputs().len();
        let (mut sums, mut count) = (vec![0.0; channels], 0);
        for part in &judge.parts {
            for k in judge.judged(part) {
                sums.iter_mut().zip(part.run.y(k)).for_each(|(sum, r)| *sum += r * r);
                count += 1;
            }
        }
        let needed = FOLDS * STRETCHES * (lag + 1);
        if count < needed {
            let what = "choosing the bias model";
            return Err(TrainingError::TooShort { what, needed, found: count });
        }
        judge.power = sums.into_iter().map(|sum| sum / count as f64).collect();
        Ok(judge)
    }

    /// Complete samples after those that fill the histories.
    fn judged<'p>(&self, part: &'p Part) -> impl Iterator<Item = usize> + use<'p> {
        let lag = self.lag;
        let mut complete = 0;
        (0..part.run.len()).filter(move |&k| {
            let is_complete = part.run.is_complete(k);
            complete += usize::from(is_complete);
            is_complete && complete > lag && part.from <= k
        })
    }

    /// The losses of every candidate of a structure and a way of learning; none for one that cannot be fitted,
    /// whose search comes to no rest, that is unstable or diverges.
    pub(super) fn losses(
        &self,
        spec: &StructureSpec,
        learning: &LearningSpec,
        orders: &[ArxOrders],
    ) -> Result<Vec<(Candidate, Option<Losses>)>, TrainingError> {
        let Some(structure) = Structure::of(spec, self.records)? else { return Ok(Vec::new()) };
        // Folds know nothing of each other but that a candidate without a model in one of them is out.
        let out: Vec<AtomicBool> = orders.iter().map(|_| AtomicBool::new(false)).collect();
        let folds: Vec<Vec<Option<Vec<f64>>>> = (0..FOLDS)
            .into_par_iter()
            .map(|fold| self.of_fold(fold, &structure, learning, orders, &out))
            .collect();
        let of_all = |candidate: usize| -> Option<Vec<f64>> {
            let each = folds.iter().map(|fold| fold[candidate].as_ref());
            Some(each.collect::<Option<Vec<_>>>()?.into_iter().flatten().copied().collect())
        };
        let losses: Vec<Option<Vec<f64>>> = (0..orders.len()).map(of_all).collect();
        let candidate = |orders: &ArxOrders| Candidate {
            structure: spec.clone(),
            orders: *orders,
            learning: learning.clone(),
        };
        Ok(orders.iter().map(candidate).zip(losses.into_iter().map(|l| l.map(Losses))).collect())
    }

    /// The losses of every candidate over the parts of a fold, having learned from all others.
    fn of_fold(
        &self,
        fold: usize,
        structure: &Structure,
        learning: &LearningSpec,
        orders: &[ArxOrders],
        out: &[AtomicBool],
    ) -> Vec<Option<Vec<f64>>> {
        let others = self.parts.iter().filter(|part| part.fold != fold);
        let others: Vec<Record> = others.map(Part::own).collect();
        let losses = |model: Option<LearnedBias>| -> Option<Vec<f64>> {
            let model = model?;
            let own = self.parts.iter().filter(|part| part.fold == fold);
            let runs = own.map(|part| self.free_run(&model, part));
            Some(runs.collect::<Option<Vec<_>>>()?.concat())
        };
        fit_all(structure, learning, orders, &others, out).into_iter().map(losses).collect()
    }

    /// The losses without any bias model.
    pub(super) fn without_bias(&self) -> Losses {
        let mut losses = Vec::new();
        for fold in 0..FOLDS {
            for part in self.parts.iter().filter(|part| part.fold == fold) {
                losses.extend(self.stretches(part, |_, r, e| e.copy_from_slice(r)));
            }
        }
        Losses(losses)
    }

    /// What a simulation from the inputs leaves of a part, its histories filled with the measured residual where the run
    /// begins.
    fn free_run(&self, model: &LearnedBias, part: &Part) -> Option<Vec<f64>> {
        let radii = model.pole_radii().ok()?;
        if radii.iter().flatten().any(|radius| *radius >= 1.0) {
            return None;
        }
        let mut running = model.freeze().ok()?;
        let mut filled = 0;
        let losses = self.stretches(part, |u, r, e| {
            if filled < self.lag {
                filled += usize::from(r.iter().all(|r| r.is_finite()));
                running.observe(u, r);
            } else {
                running.simulate(u, e);
                e.iter_mut().zip(r).for_each(|(e, r)| *e = r - *e);
            }
        });
        losses.iter().all(|loss| loss.is_finite()).then_some(losses)
    }

    /// The mean relative square of what `left` writes, stretch by stretch. `left` sees every sample whose inputs are
    /// there, and what it writes counts where the residual is there and histories are full.
    fn stretches(
        &self,
        Part { run, from, .. }: &Part,
        mut left: impl FnMut(&[f64], &[f64], &mut [f64]),
    ) -> Vec<f64> {
        let channels = run.outputs().len();
        let mut sums = [(0.0, 0_u32); STRETCHES];
        let (mut e, mut filled) = (vec![0.0; channels], 0);
        let mut held = vec![0.0; run.inputs().len()];
        for k in 0..run.len() {
            held.iter_mut().zip(run.u(k)).filter(|(_, u)| u.is_finite()).for_each(|(h, u)| *h = *u);
            let is_complete = run.is_complete(k);
            if filled < self.lag && !is_complete {
                continue;
            }
            left(&held, run.y(k), &mut e);
            filled += usize::from(is_complete);
            if is_complete && filled > self.lag && *from <= k {
                let squares = e.iter().zip(&self.power).filter(|(_, power)| **power > 0.0);
                let (sum, count) = &mut sums[(k - from) * STRETCHES / (run.len() - from)];
                *sum += squares.map(|(e, power)| e * e / power).sum::<f64>() / channels as f64;
                *count += 1;
            }
        }
        sums.iter().filter(|(_, n)| *n > 0).map(|(sum, n)| sum / f64::from(*n)).collect()
    }
}

/// Models of all orders that are not `out`; those by least squares share one factorisation.
fn fit_all(
    structure: &Structure,
    learning: &LearningSpec,
    orders: &[ArxOrders],
    records: &[Record],
    out: &[AtomicBool],
) -> Vec<Option<LearnedBias>> {
    let shares = matches!(structure, Structure::Linear | Structure::Hammerstein(_))
        && *learning == LearningSpec::default();
    let Some(seen) = structure.seen(records).ok().filter(|_| shares) else {
        let fitted = |(orders, out): (&ArxOrders, &AtomicBool)| {
            if out.load(Ordering::Relaxed) {
                return None;
            }
            let model = fit(structure, learning, *orders, records, Search::ToRest).ok();
            out.fetch_or(model.is_none(), Ordering::Relaxed);
            model
        };
        return orders.iter().zip(out).map(fitted).collect();
    };
    let seen: Vec<&Record> = seen.iter().collect();
    let Ok(table) = select_orders(orders, &LeastSquares::new(), &seen, &[]) else {
        return vec![None; orders.len()];
    };
    let model = |orders: &ArxOrders| {
        let found = table.scores().iter().find(|score| score.orders == *orders)?;
        let linear = found.model.clone().ok()?;
        match structure {
            Structure::Hammerstein(expansion) => {
                HammersteinModel::new(expansion.clone(), linear).ok().map(LearnedBias::Hammerstein)
            }
            _ => Some(LearnedBias::Linear(linear)),
        }
    };
    orders.iter().map(model).collect()
}
