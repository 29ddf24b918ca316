//! The kinds of cases.

use serde::{Deserialize, Serialize};

use super::laws::Origin;

/// The kinds of cases. The first five are runs in the open loop from rest, or in a loop whose
/// controller is in the model; the others are logs as people have them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CaseKind {
    /// One effect, of a law that the library has.
    Single,
    /// No effect: parameters and initial states only.
    None,
    /// An effect of a class that the library does not have.
    Withheld,
    /// Two effects.
    Pair,
    /// One effect whose label the library has, but not its law.
    Mismatch,
    /// One effect, in a loop with a controller that is not in the model.
    Loop,
    /// No effect in such a loop.
    LoopNone,
    /// One effect in an unstable plant, which such a controller holds.
    Unstable,
    /// No effect in an unstable plant.
    UnstableNone,
    /// One effect in one run that is cut in two: the held-out part goes on where the other ends.
    Cut,
    /// No effect in a run that is cut in two.
    CutNone,
    /// One effect; the logs begin while the plant is in motion.
    InMotion,
    /// No effect in logs that begin in motion.
    InMotionNone,
    /// One large effect among three small ones.
    Dominant,
    /// One effect in a log of coarse steps and a short range.
    Coarse,
    /// No effect in such a log.
    CoarseNone,
    /// One effect in a log of a jittering clock, of which samples and rows are missing.
    Patchy,
    /// No effect in such a log.
    PatchyNone,
    /// A mistake in the reading of the log, and no effect.
    Misread,
    /// A parameter that walks at random.
    Wander,
    /// An effect on a signal inside the model.
    Inside,
}

impl CaseKind {
    /// All kinds.
    pub const ALL: [Self; 21] = [
        Self::Single,
        Self::None,
        Self::Withheld,
        Self::Pair,
        Self::Mismatch,
        Self::Loop,
        Self::LoopNone,
        Self::Unstable,
        Self::UnstableNone,
        Self::Cut,
        Self::CutNone,
        Self::InMotion,
        Self::InMotionNone,
        Self::Dominant,
        Self::Coarse,
        Self::CoarseNone,
        Self::Patchy,
        Self::PatchyNone,
        Self::Misread,
        Self::Wander,
        Self::Inside,
    ];

    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::None => "none",
            Self::Withheld => "withheld",
            Self::Pair => "pair",
            Self::Mismatch => "mismatch",
            Self::Loop => "loop",
            Self::LoopNone => "loop-none",
            Self::Unstable => "unstable",
            Self::UnstableNone => "unstable-none",
            Self::Cut => "cut",
            Self::CutNone => "cut-none",
            Self::InMotion => "in-motion",
            Self::InMotionNone => "in-motion-none",
            Self::Dominant => "dominant",
            Self::Coarse => "coarse",
            Self::CoarseNone => "coarse-none",
            Self::Patchy => "patchy",
            Self::PatchyNone => "patchy-none",
            Self::Misread => "misread",
            Self::Wander => "wander",
            Self::Inside => "inside",
        }
    }

    /// Effects that are put in.
    pub(super) fn effects(self) -> usize {
        match self {
            Self::Misread => 0,
            kind if kind.is_null() => 0,
            Self::Pair => 2,
            Self::Dominant => 4,
            _ => 1,
        }
    }

    /// Whether nothing is wrong.
    #[must_use]
    pub fn is_null(self) -> bool {
        matches!(
            self,
            Self::None
                | Self::LoopNone
                | Self::UnstableNone
                | Self::CutNone
                | Self::InMotionNone
                | Self::CoarseNone
                | Self::PatchyNone
        )
    }

    /// Where the laws of its effects come from.
    pub(super) fn origin(self) -> Origin {
        match self {
            Self::Withheld => Origin::Withheld,
            Self::Mismatch => Origin::Mismatch,
            Self::Wander => Origin::Wander,
            Self::Inside => Origin::Inside,
            _ => Origin::Matched,
        }
    }

    /// Whether a controller that is not in the model closes a loop.
    #[must_use]
    pub fn is_looped(self) -> bool {
        matches!(self, Self::Loop | Self::LoopNone | Self::Unstable | Self::UnstableNone)
    }

    /// Whether the plant is unstable without its controller.
    #[must_use]
    pub fn is_unstable(self) -> bool {
        matches!(self, Self::Unstable | Self::UnstableNone)
    }

    /// Whether it is of the first five kinds.
    pub(super) fn is_plain(self) -> bool {
        self <= Self::Mismatch
    }

    /// Whether one cause is to be named, which refits can hold against the truth.
    pub(super) fn has_one_effect(self) -> bool {
        self.effects() == 1 && self != Self::Withheld
    }
}
