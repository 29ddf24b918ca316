//! The judgement: what was concluded from the evidence.

use crate::{
    diagnose::{
        judge::Probabilities,
        result::{CauseId, Pair, PairId, Regime, RivalCause, Verdict},
        sets::EffectSet,
        weigh::{answer::Answer, lack_of_fit::LackOfFit, singles::Singles},
    },
    fit::Horizon,
};

/// What was made of the evidence.
#[derive(Debug)]
pub(in crate::diagnose) struct Judged<'a> {
    pub verdict: Verdict,
    pub regime: Regime,
    /// Of the answers that are neither a cause nor a pair.
    pub probabilities: Probabilities,
    /// Single causes with their probabilities, the most probable first.
    pub singles: Singles<'a>,
    pub ties: Ties,
    pub pairs: NamedPairs,
    /// The best answer; where the verdict is that there is no gap, it is not what is reported.
    pub best: Answer,
    pub lack_of_fit: LackOfFit,
    /// Horizons at which held-out gaps are reported.
    pub horizons: Vec<Horizon>,
    /// Windows that fits were made in, where free runs are lost.
    pub windows: Option<Horizon>,
}

/// Causes near the first one.
#[derive(Clone, Debug, Default)]
pub(in crate::diagnose) struct Ties {
    /// Those that the log cannot tell from it, itself among them.
    pub tied: Vec<CauseId>,
    /// Those that it can tell from it.
    pub rivals: Vec<RivalCause>,
}

/// Pairs that are worth being called so.
#[derive(Debug, Default)]
pub(in crate::diagnose) struct NamedPairs {
    /// The pairs, the best first.
    pub pairs: Vec<Pair>,
    /// Those that the log cannot tell from the first, itself among them.
    pub tied: Vec<PairId>,
    /// The fits of those of two simulated causes.
    pub fitted: Vec<EffectSet>,
}
