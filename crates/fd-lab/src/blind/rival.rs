//! What refits to the noise-free truth leave, and the effects by which they leave little.

use fd_effect::Candidate;
use serde::{Deserialize, Serialize};

/// What refits to the noise-free truth leave, in squares of the noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Oracle {
    /// By the nominal model, with nuisances around the truth or around what the model file says,
    /// whatever is less: below 9 the case is invisible.
    pub nothing: f64,
    /// By single effects of the library that leave less than 9: they cannot be told from the truth.
    pub ties: Vec<Rival>,
    /// The least that any single effect of the library leaves.
    pub best: Option<Rival>,
}

/// An effect of the library with what it leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rival {
    /// Label.
    pub label: String,
    /// Name of its site.
    pub site: String,
    /// The other end of a coupling.
    pub partner: Option<String>,
    /// Mechanism.
    pub family: String,
    /// Law that leaves the least.
    pub law: String,
    /// What it leaves.
    pub distance: f64,
}

impl Rival {
    pub(super) fn of(candidate: &Candidate) -> Self {
        Self {
            label: candidate.label.to_owned(),
            site: candidate.site.name().unwrap_or_default().to_owned(),
            partner: candidate.partner.as_ref().and_then(|p| p.name()).map(str::to_owned),
            family: candidate.family.to_owned(),
            law: candidate.law.to_owned(),
            distance: f64::INFINITY,
        }
    }

    pub(super) fn is_same(&self, other: &Self) -> bool {
        self.label == other.label && self.site == other.site && self.partner == other.partner
    }
}
