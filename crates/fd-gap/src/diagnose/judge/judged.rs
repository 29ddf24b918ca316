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
    pub(in crate::diagnose) verdict: Verdict,
    pub(in crate::diagnose) regime: Regime,
    /// Of the answers that are neither a cause nor a pair.
    pub(in crate::diagnose) probabilities: Probabilities,
    /// Single causes with their probabilities, the most probable first.
    pub(in crate::diagnose) singles: Singles<'a>,
    pub(in crate::diagnose) ties: Ties,
    pub(in crate::diagnose) pairs: NamedPairs,
    /// The best answer; where the verdict is that there is no gap, it is not what is reported.
    pub(in crate::diagnose) best: Answer,
    pub(in crate::diagnose) lack_of_fit: LackOfFit,
    /// Horizons at which held-out gaps are reported.
    pub(in crate::diagnose) horizons: Vec<Horizon>,
    /// Windows that fits were made in, where free runs are lost.
    pub(in crate::diagnose) windows: Option<Horizon>,
}

/// Causes near the first one.
#[derive(Clone, Debug, Default)]
pub(in crate::diagnose) struct Ties {
    /// Those that the log cannot tell from it, itself among them.
    pub(in crate::diagnose) tied: Vec<CauseId>,
    /// Those that it can tell from it.
    pub(in crate::diagnose) rivals: Vec<RivalCause>,
}

/// Pairs that are worth being called so.
#[derive(Debug, Default)]
pub(in crate::diagnose) struct NamedPairs {
    /// The pairs, the best first.
    pub(in crate::diagnose) pairs: Vec<Pair>,
    /// Those that the log cannot tell from the first, itself among them.
    pub(in crate::diagnose) tied: Vec<PairId>,
    /// The fits of those of two simulated causes.
    pub(in crate::diagnose) fitted: Vec<EffectSet>,
}
