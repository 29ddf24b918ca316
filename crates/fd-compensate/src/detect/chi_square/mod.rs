//! The energy of a vector residual in the metric of its own covariance.
//!
//! ```text
//! q(k) = Σ_{j = k−N+1 … k} (r(j) − m)ᵀ Σ⁻¹ (r(j) − m)
//! ```
//!
//! With white Gaussian residuals of mean `m` and covariance `Σ`, `q` is chi-square distributed with
//! `N · channels` degrees of freedom (Willsky & Jones; Basseville & Nikiforov 1993, section 7.3), which
//! gives [`threshold`] in closed form. `N = 1` looks at each sample alone; a longer window trades delay
//! for smaller faults.
//!
//! **Assumptions.** `m` and `Σ` are known; residuals are white and Gaussian if the closed-form
//! threshold is used. Coloured residuals make `q` of a window spread wider than chi-square: calibrate.
//!
//! **Not to be used** with channels that depend on each other linearly (an error at design), nor
//! where the direction of the fault is known; a matched filter is then stronger.

mod design;
mod run;

pub(crate) use self::design::{moments, whitening};
pub use self::{design::threshold, run::ChiSquare};
