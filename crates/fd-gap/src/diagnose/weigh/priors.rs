//! Probabilities of the answers before the data.

use crate::diagnose::settings::Settings;

/// Probabilities of the answers before the data.
#[derive(Clone, Copy, Debug)]
pub(in crate::diagnose) struct Priors {
    pub(in crate::diagnose) no_gap: f64,
    /// Of each single cause.
    pub(in crate::diagnose) cause: f64,
    /// Of each pair of causes, of which only the promising ones are tried.
    pub(in crate::diagnose) pair: f64,
}

impl Priors {
    /// With so many single causes, unless the settings say otherwise.
    pub(in crate::diagnose) fn of(settings: &Settings, causes: usize) -> Self {
        let Settings { no_gap, unknown, two, .. } = *settings;
        let causes = settings.causes.unwrap_or(causes);
        let share = |all: f64, n: usize| all / n.max(1) as f64;
        Self {
            no_gap,
            cause: share((1.0 - no_gap) * (1.0 - unknown - two), causes),
            pair: share((1.0 - no_gap) * two, causes * causes.saturating_sub(1) / 2),
        }
    }

    /// Evidence from which a single cause is more probable than no gap.
    pub(super) fn worth(&self, temperature: f64) -> f64 {
        temperature * (self.no_gap / self.cause).ln()
    }
}
