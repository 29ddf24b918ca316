//! When to look for effects on signals inside a model, and when to believe them.

use fd_effect::SiteRef;

use super::{Cause, Diagnosis, Verdict};
use crate::diagnose::{settings::Settings, weigh::answer::is_a_pair};

/// Labels of what follows one log as it pleases.
const CURVES: [&str; 4] = ["input-map", "force-map", "sensor-map", "parameter-wander"];

impl Diagnosis {
    /// Whether signals inside the model are worth trying: nothing explains the logs down to the noise, or it takes two
    /// effects or one that follows anything, or held-out logs do not show the one that is named. One law inside may
    /// stand for any of these.
    #[must_use]
    pub fn leaves_room_inside(&self) -> bool {
        let is_shown = || {
            let forecast = self.held_out.first().filter(|held_out| !held_out.is_redrawn);
            let closed = forecast.and_then(|held_out| held_out.closed_of_refit);
            closed.is_none_or(|closed| 0.0 < closed.interval[0])
        };
        match self.verdict {
            Verdict::NoGap => false,
            Verdict::Cause | Verdict::Tied => {
                let is_law = self.causes.first().is_some_and(|cause| !cause.follows_anything());
                !(self.names_all() && is_law && is_shown())
            }
            Verdict::Pair | Verdict::NoneOfThese | Verdict::Unclear => true,
        }
    }

    /// Settings of a diagnosis of signals inside: where what is around the model explains the logs, only one law is
    /// looked for.
    #[must_use]
    pub fn settings_inside(&self, settings: &Settings) -> Settings {
        let two = if self.names_all() { 0.0 } else { settings.two };
        Settings { two, ..settings.clone() }
    }

    /// Whether this diagnosis, of a model with names for the signals inside, is to be reported instead of that of what
    /// is `around` the model: it explains the logs down to the noise, and where that one does so as well, it needs one
    /// law inside for it, of which the evidence is no less than that of two effects is worth, or clearly more than that
    /// of one.
    #[must_use]
    pub fn is_to_replace(&self, around: &Self, bayes_factor: f64) -> bool {
        if !self.names_all() || !around.names_all() {
            return self.names_all();
        }
        let (Some(own), Some(other)) = (self.causes.first(), around.causes.first()) else {
            return false;
        };
        let is_inside = matches!(own.site, SiteRef::Signal(..)) && !own.follows_anything();
        let is_single = matches!(self.verdict, Verdict::Cause | Verdict::Tied);
        let (own, other) = (own.log_evidence, other.log_evidence);
        let is_more = match (around.verdict, around.pairs.first()) {
            (Verdict::Pair, Some(pair)) => !is_a_pair(pair.log_evidence, own),
            _ => other + bayes_factor.ln() < own,
        };
        is_inside && is_single && is_more
    }
}

impl Cause {
    /// Whether it follows one log as it pleases: a free curve, or a parameter that wanders.
    fn follows_anything(&self) -> bool {
        CURVES.contains(&self.label)
    }
}
