//! Several effects at once: which of them are named, and which of them the log holds at all.

use super::{
    cause::{is_exact, left, sought},
    said::said_of,
    verdict::{OfSeveral, Verdict},
};
use crate::blind::{
    answer::{Answer, Named},
    error::BlindError,
    files::Case,
    kind::CaseKind,
    oracle::SEPARATED,
    truth::{Effect, Truth},
};

/// Whether all effects are named, or causes that no log could tell from them together.
pub(super) fn judge_list(
    case: Option<&Case>,
    truth: &Truth,
    answer: &Answer,
    first: Option<&Named>,
    corrupts: bool,
    verdict: &mut Verdict,
) -> Result<(), BlindError> {
    let said: Vec<&Named> = if answer.together.is_empty() {
        first.into_iter().collect()
    } else {
        answer.together.iter().collect()
    };
    let is_of =
        |effect: &Effect, n: &Named| is_exact(effect, &n.label, &n.site, n.partner.as_deref());
    let is_said = |effect: &&Effect| said.iter().any(|named| is_of(effect, named));
    let found = truth.effects.iter().filter(is_said).count();
    let all = truth.effects.len();
    let is_exact_list = found == all && said.len() == all;
    verdict.is_half_exact = 0 < found;
    verdict.named_of_several = [
        said.iter().filter(|named| truth.effects.iter().any(|effect| is_of(effect, named))).count(),
        said.len(),
    ];
    let seen = case.filter(|_| verdict.is_visible && !corrupts);
    if let Some(case) = seen {
        for effect in &truth.effects {
            let others = truth.effects.iter().filter(|other| !std::ptr::eq(*other, effect));
            let others = others.map(|e| (said_of(e), e.site.as_str(), e.partner.as_deref()));
            let worth = left(case, truth, others)?;
            verdict.of_several.push(OfSeveral { worth, is_named: is_said(&effect) });
        }
    }
    let is_list_right = is_exact_list
        || match seen {
            Some(case) if !said.is_empty() => {
                left(case, truth, said.iter().map(|named| sought(named)))? < SEPARATED
            }
            _ => false,
        };
    if truth.kind == CaseKind::Pair {
        (verdict.is_pair_exact, verdict.is_pair_right) = (is_exact_list, is_list_right);
        return Ok(());
    }
    verdict.is_list_right = is_list_right;
    // What is named first where several are named is the first of them, whatever is most probable alone.
    let first = answer.together.first().or(first);
    verdict.is_dominant_first = first.is_some_and(|named| is_of(&truth.effects[0], named))
        || match (case, first) {
            (Some(case), Some(first)) => {
                let effects = truth.effects[..1].to_vec();
                let alone = Truth { effects, ..truth.clone() };
                left(case, &alone, [sought(first)])? < SEPARATED
            }
            _ => false,
        };
    verdict.is_right = verdict.is_dominant_first;
    Ok(())
}
