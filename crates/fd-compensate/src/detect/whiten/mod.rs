//! Residuals made white in time and across channels.
//!
//! ```text
//! ν_c(k) = z_c(k) − Σ_i a_ci z_c(k−i),   z = r − m          prediction error of each channel
//! e(k)   = W ν(k),   Wᵀ W = cov(ν)⁻¹                        then white across channels
//! ```
//!
//! The coefficients of each channel come from the Yule-Walker equations (Levinson's recursion), their
//! number from Akaike's criterion; the prediction errors are then as white as a linear model of the channel
//! makes them.
//!
//! A fault that adds `s(k)` to the residual adds `W (s_c(k) − Σ_i a_ci s_c(k−i))` to `e`:
//! [`WhitenerDesign::response`]. A detector must look for that and not for `s`; a step, for example, becomes a
//! jump that partly fades.
//!
//! **Assumptions.** The fault-free residual is stationary. The past before the first sample is taken to
//! be the mean, so the first samples are whitened in part only.
//!
//! **Not to be used** before a detector that looks for slow drifts of the plant's own: whitening takes the
//! slow part of the noise out and the slow part of the fault with it.

mod design;
mod run;

pub use self::{design::WhitenerDesign, run::Whitener};
