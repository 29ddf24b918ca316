//! From where an answer counts as sure, or as none.

/// Share of wrong abstentions at which "none of these" is counted.
pub(super) const FALSE_ABSTENTION: f64 = 0.03;

/// Probability from which an answer counts as sure.
pub(super) const SURE: f64 = 0.9;
