//! Probabilities of the answers before the data.

use crate::diagnose::settings::Settings;

/// Probabilities of the answers before the data.
#[derive(Clone, Copy, Debug)]
pub(in crate::diagnose) struct Priors {
    pub no_gap: f64,
    /// Of each single cause.
    pub cause: f64,
    /// Of each pair of causes, of which only the promising ones are tried.
    pub pair: f64,
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

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "numbers that are exact in binary")]
mod tests {
    use super::*;

    /// No gap, the causes, the pairs and what is unknown add up to one.
    #[test]
    fn what_is_not_given_to_one_is_given_to_the_others() {
        let settings =
            Settings { no_gap: 0.5, unknown: 0.25, two: 0.25, causes: None, ..Settings::default() };
        let priors = Priors::of(&settings, 4);
        assert_eq!((priors.no_gap, priors.cause, priors.pair), (0.5, 0.0625, 0.125 / 6.0));
        let of_two = Priors::of(&Settings { causes: Some(2), ..settings.clone() }, 4);
        assert_eq!((of_two.cause, of_two.pair), (0.125, 0.125));
        // A single cause has no second one, and none is no division by zero.
        for causes in [0, 1] {
            let priors = Priors::of(&settings, causes);
            assert_eq!((priors.cause, priors.pair), (0.25, 0.125));
        }
    }

    #[test]
    fn a_cause_is_worth_it_when_it_is_as_probable_as_no_gap() {
        let priors = Priors { no_gap: 0.5, cause: 0.02, pair: 0.001 };
        for temperature in [1.0, 2.5] {
            let evidence = priors.worth(temperature);
            let odds = priors.cause / priors.no_gap * (evidence / temperature).exp();
            assert!((odds - 1.0).abs() < 1e-12, "{odds}");
        }
    }
}
