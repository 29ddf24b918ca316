//! Bias models with a static nonlinearity before the dynamics (Hammerstein).
//!
//! ```text
//! x_j(k) = f_j(u(k))            f: powers, or pieces of straight lines
//! A(q) μ(k) = Σ_j B_j(q) x_j(k) + c
//! ```
//!
//! Source: Chang & Luus (1971), *A noniterative method for identification using Hammerstein
//! model*: with one numerator per basis function the equation stays linear in its parameters, so
//! the nonlinear bias is an ordinary [`ArxModel`](crate::arx::ArxModel) with more inputs, and
//! every way to learn those (least squares, instruments, output error, recursive) serves it.
//! Since each basis function has dynamics of its own, the class is wider than a single curve
//! followed by a single transfer function.
//!
//! Powers go on as a straight line beyond the range that they were learned on; so do pieces of
//! lines by nature. A bias is thus never extrapolated by a power.
//!
//! # When not to use it
//!
//! When the *poles* move with the operating point rather than the gain: see
//! [`scheduled`](crate::scheduled). When the training data do not reach into the nonlinear range:
//! the extra parameters then fit noise.

mod expansion;
mod model;
mod run;

pub use self::{
    expansion::{Basis, Curve, Expansion},
    model::HammersteinModel,
    run::{Expanded, Expander},
};
