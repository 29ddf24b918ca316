//! Which bias model: every form is compared by free runs over healthy samples that its fit has not seen.
//!
//! One-step errors do not tell: the compensation simulates (eq. 16), and a pole within a hair of 1 that stands for a
//! constant predicts well and drifts away in simulation. Of all forms the simplest is taken that is within one standard
//! error of the best (Breiman et al. 1984, section 3.4.3), with errors paired stretch by stretch; no bias at all is
//! one of the forms.

mod candidates;
mod free_run;

use fd_ident::arx::ArxOrders;
use fd_model::Record;
use serde::{Deserialize, Serialize};

pub(super) use self::candidates::Candidate;
use self::free_run::{Judge, Losses};
use super::error::TrainingError;
use crate::spec::{LearningSpec, PipelineSpec, StructureSpec};

/// One form of the bias model and what its free runs left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compared {
    /// Structure, orders and way of learning in words.
    pub model: String,
    /// Parameters of one residual channel.
    pub parameters: usize,
    /// Root mean square of `r − μ̂` relative to that of `r`, all channels alike; none when it could not be fitted or
    /// diverged.
    pub left: Option<f64>,
    /// Its mean square above that of the best, relative to that of `r`.
    pub above_best: Option<f64>,
    /// Standard error of that.
    pub standard_error: Option<f64>,
    /// Whether it is the one that was taken.
    pub chosen: bool,
}

/// What was chosen, and from what.
#[derive(Clone, Debug)]
pub(super) struct Choice {
    /// None when no bias model is worth its parameters.
    pub candidate: Option<Candidate>,
    /// The simplest first.
    pub table: Vec<Compared>,
}

/// Compares all forms that a spec leaves open, with orders up to `most`.
pub(super) fn choose(
    spec: &PipelineSpec,
    most: usize,
    records: &[Record],
) -> Result<Choice, TrainingError> {
    let widest = most + candidates::DELAYS.iter().max().copied().unwrap_or(0);
    let (judge, lag) = Judge::of_widest(records, widest)?;
    let nu = records[0].inputs().len();
    let mut tried: Vec<(Candidate, Option<Losses>)> = Vec::new();
    let is_open = spec.bias.learning == LearningSpec::default();
    // On-line ways of learning are compared by what they converge to.
    let learning = match &spec.bias.learning {
        learning if learning.is_on_line() => LearningSpec::default(),
        learning => learning.clone(),
    };
    let mut orders = candidates::orders(most);
    orders.retain(|orders| orders.lag() <= lag);
    tried.extend(judge.losses(&spec.bias.structure, &learning, &orders)?);
    let found = best(&tried).cloned();
    let has_free_structure = spec.bias.structure == StructureSpec::default() && nu > 0;
    if let Some(found) = &found {
        if has_free_structure {
            for structure in candidates::structures(found, nu, records)? {
                tried.extend(judge.losses(&structure, &found.learning, &[found.orders])?);
            }
        }
        if is_open {
            // Output error needs fewer poles than least squares, which spend some on the noise.
            let fewer: Vec<ArxOrders> = (1..=found.orders.na)
                .map(|n| ArxOrders { na: n, nb: n + 1, ..found.orders })
                .collect();
            let output_error = LearningSpec::OutputError { from_rest: false };
            tried.extend(judge.losses(&spec.bias.structure, &output_error, &fewer)?);
        }
    }
    Ok(decide(tried, judge.without_bias(), nu))
}

/// The candidate of least loss.
fn best(tried: &[(Candidate, Option<Losses>)]) -> Option<&Candidate> {
    let judged = tried.iter().filter_map(|(tried, losses)| Some((tried, losses.as_ref()?.mean())));
    judged.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(candidate, _)| candidate)
}

fn decide(tried: Vec<(Candidate, Option<Losses>)>, without_bias: Losses, nu: usize) -> Choice {
    let mut all: Vec<(Option<Candidate>, Option<Losses>)> = vec![(None, Some(without_bias))];
    all.extend(tried.into_iter().map(|(candidate, losses)| (Some(candidate), losses)));
    let parameters = |candidate: &Option<Candidate>| match candidate {
        Some(candidate) => candidate.parameters(nu),
        None => 0,
    };
    let loss = |losses: &Option<Losses>| losses.as_ref().map_or(f64::INFINITY, Losses::mean);
    // Of equally simple forms the better one comes first, whatever the order of the inputs.
    all.sort_by(|(a, loss_a), (b, loss_b)| {
        parameters(a).cmp(&parameters(b)).then(loss(loss_a).total_cmp(&loss(loss_b)))
    });
    let least = (0..all.len()).min_by(|&i, &j| loss(&all[i].1).total_cmp(&loss(&all[j].1)));
    let least = least.unwrap_or(0);
    // Without a bias there always is a loss.
    let reference = all[least].1.clone();
    let above = |losses: &Option<Losses>| Some(losses.as_ref()?.above(reference.as_ref()?));
    let chosen = all
        .iter()
        .position(|(_, losses)| above(losses).is_some_and(|(mean, error)| mean <= error))
        .unwrap_or(least);
    let row = |(i, (candidate, losses)): (usize, &(Option<Candidate>, Option<Losses>))| {
        let (above_best, standard_error) = above(losses).unzip();
        Compared {
            model: candidate.as_ref().map_or_else(|| "none".to_owned(), Candidate::in_words),
            parameters: parameters(candidate),
            left: losses.as_ref().map(|losses| losses.mean().sqrt()),
            above_best,
            standard_error,
            chosen: i == chosen,
        }
    };
    let table = all.iter().enumerate().map(row).collect();
    Choice { candidate: all.swap_remove(chosen).0, table }
}
