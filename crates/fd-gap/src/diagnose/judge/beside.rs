//! A cause of the measurement beside the best simulated answer.

use crate::{
    diagnose::{
        candidates::Candidates,
        result::{CauseId, Pair},
        sets::EffectSet,
        weigh::{
            answer::Answer,
            measurement::{Measured, MeasurementCause, weigh_measurement},
            rank::{RankedCause, measured_cause},
            singles::Singles,
        },
    },
    evidence::grades::VERY_STRONG,
};

/// A cause of the measurement beside a simulated one.
#[derive(Debug)]
pub(super) struct Beside<'a> {
    pub pair: Pair,
    pub measured: MeasurementCause<'a>,
}

impl<'a> Beside<'a> {
    /// The best one beside the first cause, which is part of the `best` answer; `None` where that
    /// has no simulated effect.
    pub(super) fn of(
        singles: &Singles<'_>,
        best: &Answer,
        candidates: &'a Candidates,
    ) -> Option<Self> {
        best.fit.as_ref()?;
        let first = &singles.causes.first()?.cause;
        let (noise, is_coloured) = (&singles.searched.noise, singles.searched.is_coloured);
        let (outputs, errors) = (&best.explanation.outputs[..], &best.errors[..]);
        let left = Measured { problem: &singles.base, outputs, errors };
        let candidates = candidates.measured.iter();
        let weighed = candidates.filter_map(|c| weigh_measurement(c, left, noise, is_coloured));
        let measured = weighed.max_by(|a, b| a.gain.total_cmp(&b.gain))?;
        let second = measured_cause(&measured, &best.explanation);
        let pair = Pair {
            probability: 0.0,
            log_evidence: first.log_evidence + measured.gain,
            gap: second.gap,
            causes: [first.clone(), second],
        };
        Some(Self { pair, measured })
    }

    /// The pair, and those of the causes that are `tied` with its first one: what the log cannot tell apart alone, it
    /// cannot beside the same cause of the measurement.
    pub(super) fn with_ties(self, causes: &[RankedCause], tied: &[CauseId]) -> Vec<Pair> {
        let Self { pair, measured } = self;
        let others = tied.iter().skip(1).filter_map(|CauseId(place)| causes.get(*place));
        let of_other = |other: &RankedCause| Pair {
            causes: [other.cause.clone(), pair.causes[1].clone()],
            log_evidence: other.cause.log_evidence + measured.gain,
            ..pair.clone()
        };
        let others: Vec<Pair> = others.map(of_other).collect();
        std::iter::once(pair).chain(others).collect()
    }

    /// Whether it belongs into the best answer: it is worth a second cause, and no pair of simulated
    /// causes is better.
    pub(super) fn is_best(&self, pairs: &[EffectSet]) -> bool {
        VERY_STRONG < self.measured.gain
            && pairs.first().is_none_or(|best| best.log_evidence < self.pair.log_evidence)
    }
}
