//! The settings of one estimator, as the kernel gets them.

use super::kernel::Settings;
use crate::{
    batch::{BatchError, LaneScalar},
    rls::{Forgetting, RlsDesign},
};

/// A design as numbers that the kernel understands, whatever the kind of forgetting.
#[derive(Clone, Copy, Debug)]
pub(super) struct LaneDesign<T> {
    pub prior_variance: T,
    pub settings: Settings<T>,
}

impl<T: LaneScalar> LaneDesign<T> {
    /// Rounds the settings of an estimator of `n` parameters to the run-time scalar.
    ///
    /// # Errors
    ///
    /// Returns an error when a setting is out of range, or the kind of forgetting is not one that
    /// lanes can share.
    pub(super) fn new(n: usize, design: &RlsDesign) -> Result<Self, BatchError> {
        design.check()?;
        let [noise, scale, growth, kept] = match design.forgetting {
            Forgetting::None => [1.0; 4],
            Forgetting::Equation18 { falling: Some(_), .. } => {
                return Err(refused("equation18 with a falling alpha"));
            }
            Forgetting::Equation18 { alpha, .. } => [alpha, 1.0, 1.0, 1.0],
            Forgetting::Exponential { lambda } => [lambda, lambda.recip(), lambda.recip(), 1.0],
            // What is forgotten lifts P along φ alone, and its trace by 1/λ at most.
            Forgetting::Directional { lambda } => [1.0, 1.0, lambda.recip(), lambda],
            Forgetting::Bounded { .. } => return Err(refused("bounded")),
            Forgetting::Resetting { .. } => return Err(refused("resetting")),
        };
        let t = T::from_design;
        let silence = match design.forgetting {
            Forgetting::Equation18 { alpha, .. } => {
                design.guard.silence::<T>(&design.forgetting) * t(alpha)
            }
            // Its weight has φᵀPφ as divisor.
            Forgetting::Directional { .. } if !design.guard.skip_silence => T::zero(),
            _ => design.guard.silence(&design.forgetting),
        };
        let prior_variance = t(design.prior_variance);
        let largest_trace = match design.forgetting {
            Forgetting::Exponential { .. } | Forgetting::Directional { .. } => {
                t(n as f64) * prior_variance * t(design.guard.trace_limit)
            }
            _ => T::one() / T::zero(),
        };
        let settings = Settings {
            noise: t(noise),
            minus_scale: -t(scale),
            silence,
            // The trace that the kernel bounds has roundings of its own.
            growth: t(growth) * (T::one() + t(8.0) * T::default_epsilon()),
            largest_trace,
            kept: t(kept),
        };
        Ok(Self { prior_variance, settings })
    }
}

fn refused(found: &'static str) -> BatchError {
    BatchError::Forgetting { found }
}
