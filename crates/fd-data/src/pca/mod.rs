//! Principal components of the channels, or of windows of them: `w ≈ P Pᵀ w` with few columns `P`.
//!
//! * **Equation.** The covariance of the centred windows is `P Λ Pᵀ + P̃ Λ̃ P̃ᵀ`; the scores are `Λ^−½ Pᵀ w`, the
//!   prediction error is `P̃ P̃ᵀ w`.
//! * **Source.** Jackson and Mudholkar (1979); windows of `lags + 1` samples (dynamic PCA) by Ku, Storer and
//!   Georgakis (1995), and so is their choice of lags.
//! * **How many components** is [`Components`]: parallel analysis (Horn 1965, Glorfeld 1995), which keeps those that stand
//!   above what independent channels would show in as many samples, a percentage of the variance, or a number.
//! * **Assumptions.** One operating point; relations between channels that are nearly linear there. Samples need
//!   not be independent for the components, but the limits by formula assume it.
//! * **Do not use** it where a few inputs drive the plant far: what they explain is taken for what is normal, and a
//!   fault along them is invisible in Q and small in T². Take [`parity`](crate::parity) or a model.

mod components;
mod design;
mod lags;

pub use self::{
    components::Components,
    design::{Pca, PcaDesign},
    lags::choose_lags,
};
