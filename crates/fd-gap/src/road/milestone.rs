//! A cause of a diagnosis as a milestone.

use super::{finish::at, result::Milestone};
use crate::{
    diagnose::{Cause, Diagnosis, Regime},
    fit::Horizon,
};

impl Milestone {
    /// A cause of which nothing but its fit is known yet.
    pub(super) fn glimpsed(cause: Cause) -> Self {
        let (probability, odds) = (0.0, 1.0);
        Self { cause, probability, tied: Vec::new(), share: None, closed: None, odds }
    }
}

/// A cause with what the diagnosis says of it.
pub(super) fn milestone(
    diagnosis: &Diagnosis,
    cause: &Cause,
    horizon: Option<Horizon>,
) -> Milestone {
    let tied = diagnosis.tied.iter().filter_map(|id| diagnosis.cause(*id));
    let (same, tied): (Vec<&Cause>, Vec<&Cause>) =
        tied.partition(|tied| tied.identity() == cause.identity());
    // Those that the log cannot tell from the first one say nothing of another.
    let tied = if same.is_empty() { Vec::new() } else { tied };
    // Near the noise "none of these" means that something else is missing as well, which is what the road is about; far above
    // it that the cause may be a mimic.
    let known = match diagnosis.regime {
        Regime::AtTheFloor => 1.0 - diagnosis.no_gap - diagnosis.none_of_these,
        Regime::AboveTheFloor => 1.0,
    };
    let known = known.max(f64::MIN_POSITIVE);
    let best = diagnosis.causes.first().map_or(0.0, |best| best.probability);
    let tied_ones: f64 = tied.iter().map(|tied| tied.probability).sum();
    let together = diagnosis.at_work(cause) + tied_ones;
    Milestone {
        cause: cause.clone(),
        probability: (together / known).min(1.0),
        tied: tied.iter().map(|cause| cause.label.to_owned()).collect(),
        share: None,
        closed: at(diagnosis, horizon).and_then(|h| h.closed_of_refit),
        odds: cause.probability / best.max(f64::MIN_POSITIVE),
    }
}
