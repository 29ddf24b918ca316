//! Linear least squares: `θ = argmin ‖y − Xθ‖²`, by orthogonal factorisation.
//!
//! Source: Businger & Golub (1965), *Linear least squares solutions by Householder
//! transformations*; eq. (16) of Patton & Chen (1992) leaves the method open. The columns of `X`
//! are first scaled to lengths between 0.7 and 1.5 by powers of two, which rounds nothing, so
//! that units do not decide what counts as singular.
//!
//! Assumes more rows than parameters, and noise in `y` only. Data that do not excite all
//! parameters are refused with rank and condition unless [`Deficient::MinimumNorm`] is asked
//! for: a bias model that was guessed in some direction would be subtracted from the residual
//! and look trustworthy.
//!
//! # When not to use it
//!
//! Sample by sample, use [`rls`](crate::rls). When the regressor itself is noisy, as past bias
//! values are, the estimate is biased towards fast poles: see [`refine`](crate::refine).

mod design;
mod modes;

pub use self::design::{Deficient, LeastSquares, LinearFit};
