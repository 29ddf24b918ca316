//! A law that forecasts before a free curve that does not.
//!
//! A force over time, a wandering parameter or an unknown curve follows a log as well as the law that made it, and
//! says nothing of the next log. Where the fitted logs cannot tell such a curve from a law, held-out logs can: what a
//! bad forecast costs ([`validate`]) is taken off the evidence of the curve, if a law that is tied with it has nothing
//! to answer for.
//!
//! *When not to use:* to choose between laws, or between curves. A right law that forecasts a run badly, because that
//! began elsewhere, would make way for a wrong one.

use super::{judged::Ties, validation::validate};
use crate::{
    diagnose::{
        candidates::follows_anything,
        context::Context,
        result::CauseId,
        weigh::{answer::Answer, rank::Basis, singles::Singles},
    },
    fit::{FitError, Log},
    shrink::Paths,
};

/// The causes in their new order, if a law comes before the curve that was the first, and its answer.
pub(super) fn law_before_curves<'a>(
    mut singles: Singles<'a>,
    ties: &Ties,
    floor: &[f64],
    held_out: &[Log],
    context: &Context<'a>,
) -> Result<(Singles<'a>, Option<Answer>), FitError> {
    let is_curve = |place: usize| singles.simulated(place).is_some_and(follows_anything);
    if held_out.is_empty() || ties.tied.len() < 2 || !is_curve(0) {
        return Ok((singles, None));
    }
    let mut losses = vec![0.0; singles.causes.len()];
    let mut does_a_law_forecast = false;
    for CauseId(place) in &ties.tied {
        let ranked = &singles.causes[*place];
        let Basis::Simulation(id) = ranked.basis else { continue };
        let Some(answer) = singles.answer_of(id, ranked.cause.log_evidence) else { continue };
        let loss = validate(&answer, floor, &singles, held_out, context.settings, Paths::AsFitted)?;
        if is_curve(*place) {
            losses[*place] = loss;
        } else {
            does_a_law_forecast |= loss <= 0.0;
        }
    }
    if !does_a_law_forecast || losses[0] <= 0.0 {
        return Ok((singles, None));
    }
    for (ranked, loss) in singles.causes.iter_mut().zip(losses) {
        ranked.cause.log_evidence -= loss.min(ranked.cause.log_evidence.max(0.0));
    }
    singles.causes.sort_by(|a, b| b.cause.log_evidence.total_cmp(&a.cause.log_evidence));
    let first = singles.first_answer();
    Ok((singles, first))
}
