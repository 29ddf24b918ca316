//! Outputs that are cut off to a grid instead of rounded.
//!
//! An integer that a driver makes of a voltage is the next one below it, not the nearest. The log is half a step too
//! small then, and reads as if the sensor had a bias of exactly that.

use super::{hypotheses::Hypothesis, mistake::Mistake};
use crate::{
    diagnose::{Case, Cause, Diagnosis},
    quality::grid_step,
};

/// Probability that a coarse column is cut off instead of rounded, before the data.
const PRIOR: f64 = 0.1;
/// The cause that a cut-off looks like.
const BIAS: &str = "sensor-bias";
/// Part of a step by which that may differ from half of one …
const NEAR: f64 = 0.1;
/// … or so many standard errors.
const ERRORS: f64 = 3.0;

/// The outputs on grids that a diagnosis says to be biased by half a step downwards, if there are any.
pub(super) fn cut_off(case: &Case<'_>, as_read: &Diagnosis) -> Option<Hypothesis> {
    let tied = as_read.tied_pairs.iter().filter_map(|id| as_read.pair(*id));
    let of_pairs = as_read.pairs.first().into_iter().chain(tied).flat_map(|pair| &pair.causes);
    let tied = as_read.tied.iter().filter_map(|id| as_read.cause(*id));
    let named = of_pairs.chain(tied).chain(as_read.causes.first());
    let (mut channels, mut steps): (Vec<String>, Vec<f64>) = (Vec::new(), Vec::new());
    for (channel, step) in named.filter_map(|cause| half_a_step(case, cause)) {
        if !channels.contains(&channel) {
            channels.push(channel);
            steps.push(step);
        }
    }
    let is_any = !channels.is_empty();
    let mistake = Mistake::CutOff { channels, steps };
    is_any.then_some(Hypothesis { mistake, log_prior: PRIOR.ln() })
}

/// The output and the step of the cut-off that a bias of a sensor may be.
fn half_a_step(case: &Case<'_>, cause: &Cause) -> Option<(String, f64)> {
    let (channel, bias) = (cause.site.name()?, cause.parameters.first()?);
    if cause.label != BIAS || 0.0 <= bias.value {
        return None;
    }
    let column = |log: &fd_model::Record| -> Vec<f64> {
        log.output_index(channel).map_or_else(Vec::new, |c| log.output(c).collect())
    };
    let measured = case.logs.iter().map(column).collect::<Vec<_>>().join(&f64::NAN);
    let step = grid_step(&measured)?;
    let off = (bias.value + 0.5 * step).abs();
    let is_half = off < (NEAR * step).max(ERRORS * bias.standard_error);
    // A bias that is known no better than the step says nothing of it.
    let is_known = bias.standard_error < NEAR * step;
    (is_half && is_known).then(|| (channel.to_owned(), step))
}
