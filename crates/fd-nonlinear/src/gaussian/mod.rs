//! What filters that carry a mean and a covariance have in common: their memory, and the two updates.
//!
//! With `P = S Sᵀ` and the deviations of states and outputs in the columns of `X` and `Y`,
//!
//! ```text
//! [ √R  Y ]        [ S_e  0   0 ]
//! [  0  X ]  Θ  =  [  K̄   S⁺  0 ],     z = S_e⁻¹ (y − ŷ),   x̂⁺ = x̂ + K̄ z
//! ```
//!
//! with `Θ` orthogonal: `S_e S_eᵀ` is the covariance of the innovation, `S⁺` the new factor (Kailath, Sayed
//! and Hassibi 2000, section 12.3; with points in place of slopes, Arasaratnam and Haykin 2009, *Cubature
//! Kalman filters*, appendix). An extended and an unscented filter differ in `X`, `Y` and `ŷ` alone.

mod estimate;
mod filter;

pub(crate) use self::{
    estimate::{Deviations, Estimate, MOST_SAMPLES},
    filter::GaussianFilter,
};
