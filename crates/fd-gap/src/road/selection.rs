//! What a stepwise selection of causes works on, and what it finds.

use std::cell::Cell;

use super::result::End;
use crate::{
    diagnose::{Diagnosis, EffectSet, HeldOut, SetSearch},
    fit::Horizon,
};

/// A diagnosis, and what is needed to go on from it.
#[derive(Clone, Copy)]
pub(super) struct Selection<'a> {
    /// Looks beside a set that can still be taken.
    pub looks: &'a Cell<usize>,
    pub first: &'a Diagnosis,
    pub search: &'a SetSearch<'a>,
    /// Most causes.
    pub most: usize,
    /// Horizon at which forecasts judge; `None` without held-out logs.
    pub horizon: Option<Horizon>,
    /// Whether a set counts only if it leaves nothing but noise.
    pub is_to_the_noise: bool,
}

impl Selection<'_> {
    /// Noise floor of held-out logs, in sigma; NaN without any.
    pub(super) fn floor(&self) -> f64 {
        let held_out = at(self.first, self.horizon);
        held_out.map_or(f64::NAN, |h| h.total(|h| &h.floor, self.search.sigma()))
    }
}

/// A set that was found, a name for each member, and why it ends there.
#[derive(Debug)]
pub(super) struct Found {
    pub set: EffectSet,
    pub named: Vec<Named>,
    pub end: End,
}

/// What is said of a cause in a set.
#[derive(Clone, Debug)]
pub(super) struct Named {
    /// Logarithm of the evidence beside all others.
    pub log_evidence: f64,
    /// Probability, together with those that the log cannot tell from it.
    pub probability: f64,
    /// Labels of these.
    pub tied: Vec<String>,
    /// Probability over that of the best cause beside the same others, curves included.
    pub odds: f64,
}

/// Held-out gaps at a horizon, or at the longest one where it is not there.
pub(super) fn at(diagnosis: &Diagnosis, horizon: Option<Horizon>) -> Option<&HeldOut> {
    let wanted = diagnosis.held_out.iter().find(|held_out| Some(held_out.horizon) == horizon);
    wanted.or_else(|| diagnosis.held_out.last())
}
