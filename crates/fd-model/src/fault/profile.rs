//! How the size of a fault develops after it has set in.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use crate::{clock::reached, domain::SampleTime, fault::error::FaultError};

/// The size `f(t)` of a fault, with `t` in seconds since it set in.
///
/// Sizes are in the unit of the channel for additive faults and pure numbers for multiplicative
/// ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[non_exhaustive]
pub enum FaultProfile {
    /// `size` at once.
    Abrupt {
        /// Size.
        size: f64,
    },
    /// A straight rise to `size` within `rise_s`, then constant.
    Incipient {
        /// Final size.
        size: f64,
        /// Time of the rise, in seconds.
        rise_s: f64,
    },
    /// A straight rise without end.
    Drift {
        /// Size gained per second.
        slope_per_s: f64,
    },
    /// `size` for a share `duty` of every period, zero for the rest.
    Intermittent {
        /// Size while it is on.
        size: f64,
        /// Period, in seconds.
        period_s: f64,
        /// Share of the period for which it is on, 0 to 1.
        duty: f64,
        /// With a seed the fault comes at a random place of each period, without one at its
        /// beginning.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        seed: Option<u64>,
    },
}

impl FaultProfile {
    /// A jump.
    ///
    /// ```
    /// # use fd_model::fault::FaultProfile;
    /// assert_eq!(FaultProfile::abrupt(0.1), FaultProfile::Abrupt { size: 0.1 });
    /// ```
    #[must_use]
    pub fn abrupt(size: f64) -> Self {
        Self::Abrupt { size }
    }

    /// A rise to `size` within `rise_s` seconds.
    ///
    /// ```
    /// # use fd_model::fault::FaultProfile;
    /// let fault = FaultProfile::incipient(0.05, 30.0);
    /// assert!(matches!(fault, FaultProfile::Incipient { rise_s: 30.0, .. }));
    /// ```
    #[must_use]
    pub fn incipient(size: f64, rise_s: f64) -> Self {
        Self::Incipient { size, rise_s }
    }

    /// A rise without end.
    ///
    /// ```
    /// # use fd_model::fault::FaultProfile;
    /// assert_eq!(FaultProfile::drift(1e-3), FaultProfile::Drift { slope_per_s: 1e-3 });
    /// ```
    #[must_use]
    pub fn drift(slope_per_s: f64) -> Self {
        Self::Drift { slope_per_s }
    }

    /// A fault that is there for the first `duty` of every period.
    ///
    /// ```
    /// # use fd_model::fault::FaultProfile;
    /// let loose_wire = FaultProfile::intermittent(0.2, 5.0, 0.1);
    /// # assert!(matches!(loose_wire, FaultProfile::Intermittent { seed: None, .. }));
    /// ```
    #[must_use]
    pub fn intermittent(size: f64, period_s: f64, duty: f64) -> Self {
        Self::Intermittent { size, period_s, duty, seed: None }
    }

    pub(super) fn check(&self) -> Result<(), FaultError> {
        let (finite, ranged) = match *self {
            Self::Abrupt { size } => (("size", size), None),
            Self::Incipient { size, rise_s } => {
                (("size", size), Some(("rise_s", "0 s or longer", rise_s, 0.0 <= rise_s)))
            }
            Self::Drift { slope_per_s } => (("slope_per_s", slope_per_s), None),
            Self::Intermittent { size, period_s, duty, .. } => {
                let ranged = if 0.0 < period_s && period_s.is_finite() {
                    ("duty", "from 0 to 1", duty, (0.0..=1.0).contains(&duty))
                } else {
                    ("period_s", "above 0 s", period_s, false)
                };
                (("size", size), Some(ranged))
            }
        };
        let (parameter, value) = finite;
        if !value.is_finite() {
            return Err(FaultError::NotFinite { parameter, value });
        }
        match ranged {
            Some((parameter, expected, value, inside)) if !(inside && value.is_finite()) => {
                Err(FaultError::Range { parameter, expected, value })
            }
            _ => Ok(()),
        }
    }

    pub(super) fn start(&self) -> RunningProfile {
        let seed = match self {
            Self::Intermittent { seed, .. } => *seed,
            _ => None,
        };
        let rng = seed.map(Xoshiro256PlusPlus::seed_from_u64);
        RunningProfile { profile: self.clone(), rng, periods: 0, place: 0.0 }
    }
}

/// A profile on its way through time.
#[derive(Debug)]
pub(super) struct RunningProfile {
    profile: FaultProfile,
    rng: Option<Xoshiro256PlusPlus>,
    /// Periods of an intermittent fault that have begun.
    periods: u64,
    /// Where in the present period the fault comes, as a share of the time that is left for it.
    place: f64,
}

impl RunningProfile {
    /// Size at `t` seconds after the fault set in; `t` must not go backwards.
    pub(super) fn at(&mut self, t: f64, ts: SampleTime) -> f64 {
        // Rounding may put the first sample an instant before the fault.
        let t = t.max(0.0);
        match self.profile {
            FaultProfile::Abrupt { size } => size,
            FaultProfile::Incipient { size, rise_s } => {
                if t < rise_s {
                    size * (t / rise_s)
                } else {
                    size
                }
            }
            FaultProfile::Drift { slope_per_s } => slope_per_s * t,
            FaultProfile::Intermittent { size, period_s, duty, .. } => {
                let mut period = (t / period_s).floor();
                if reached(t, (period + 1.0) * period_s, ts) {
                    period += 1.0;
                }
                // Every period draws once, so the pattern does not depend on the sample time.
                while (self.periods as f64) <= period {
                    self.place = self.rng.as_mut().map_or(0.0, RngExt::random);
                    self.periods += 1;
                }
                let on = (period + self.place * (1.0 - duty)) * period_s;
                let is_on = reached(t, on, ts) && !reached(t, on + duty * period_s, ts);
                if is_on { size } else { 0.0 }
            }
        }
    }
}
