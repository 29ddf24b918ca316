//! Single causes in the order of their evidence, less what bad forecasts cost them.
//!
//! A force over time, a wandering parameter or an unknown curve follows a log as well as the law that made it, and
//! says nothing of the next log. Evidence of the fitted logs ties such a cause with the law; held-out logs do not.
//! So the first cause answers for its forecast: what that costs ([`validate`]) is taken off its evidence, and the
//! cause that then comes first answers next, until one comes first that has nothing to answer for.
//!
//! *When not to use:* far above the noise, where forecasts are all that counts; and for two causes together.

use super::validation::validate;
use crate::{
    diagnose::{
        context::Context,
        weigh::{
            answer::Answer,
            rank::{Basis, RankedCause},
            singles::Singles,
        },
    },
    fit::{FitError, Log},
};

/// Causes that have to answer for their forecasts, at most.
const MOST: usize = 8;

/// The causes in their new order, and the answer of the first of them if that has changed.
pub(super) fn forecasting<'a>(
    singles: Singles<'a>,
    floor: &[f64],
    held_out: &[Log],
    context: &Context<'a>,
) -> Result<(Singles<'a>, Option<Answer>), FitError> {
    let mut singles = singles;
    let mut best = None;
    let mut answered: Vec<Basis> = Vec::new();
    while answered.len() < MOST {
        let Some(RankedCause { basis, cause }) = singles.causes.first() else { break };
        let (basis, log_evidence) = (*basis, cause.log_evidence);
        if log_evidence <= 0.0 {
            break;
        }
        let Some(answer) = singles.first_answer() else { break };
        let is_known = answered.contains(&basis);
        let is_first = answered.is_empty();
        let loss = if is_known {
            0.0
        } else {
            validate(&answer, floor, &singles, held_out, context.settings)?.loss
        };
        if loss <= 0.0 {
            best = (!is_first).then_some(answer);
            break;
        }
        answered.push(basis);
        singles.causes[0].cause.log_evidence -= loss.min(log_evidence);
        singles.causes.sort_by(|a, b| b.cause.log_evidence.total_cmp(&a.cause.log_evidence));
        best = singles.first_answer();
    }
    Ok((singles, best))
}
