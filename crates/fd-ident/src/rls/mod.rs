//! Recursive least squares: `θ(k) = θ(k−1) + K(k) [y(k) − φᵀ(k) θ(k−1)]`.
//!
//! Source: eq. (18) of Patton & Chen (1992), with the factorisation of Bierman (1977) and the kinds of
//! forgetting listed at [`Forgetting`]. A [`RlsKernel`] owns the covariance and the caller owns `θ`, so that
//! the parameters of several residual channels can be stored side by side.
//!
//! | kernel | memory | use it for |
//! |---|---|---|
//! | [`UdRls`] | all samples, weighted by age | everything; the default |
//! | [`WindowRls`] | exactly the last `W` samples | abrupt changes that must be forgotten completely |
//! | [`ConventionalRls`] | as `UdRls` | comparison, never for `f32` |
//! | [`QrRls`] | as `UdRls` | the reference for the others |
//!
//! Assumes a white equation error; otherwise the estimate is biased, as with any least squares (see
//! [`refine`](crate::refine)).
//!
//! # When not to use it
//!
//! With all data at hand, [`least_squares`](crate::least_squares) is more accurate and reports
//! the rank.

mod conventional;
mod covariance;
mod forgetting;
mod kernel;
mod qr;
mod recursion;
mod storage;
mod ud;
mod window;

pub use self::{
    conventional::Conventional,
    covariance::Covariance,
    forgetting::{Falling, Forgetting, Guard, RlsDesign},
    kernel::RlsKernel,
    qr::QrRls,
    recursion::Rls,
    storage::{Grid, RlsStorage, Static},
    ud::Ud,
    window::{WindowDesign, WindowRls},
};
pub(crate) use self::{
    covariance::{add_scaled, rounding},
    forgetting::positive,
    kernel::check_parameters,
};

/// Recursive least squares on `U D Uᵀ`.
pub type UdRls<T = f64, S = fd_core::Heap> = Rls<T, Ud<T, S>>;

/// Recursive least squares on the covariance itself.
pub type ConventionalRls<T = f64, S = fd_core::Heap> = Rls<T, Conventional<T, S>>;
