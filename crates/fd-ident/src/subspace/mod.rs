//! One state-space model for all residual channels, by subspace identification.
//!
//! ```text
//! x(k+1) = A x(k) + B u(k),    μ(k) = C x(k) + D u(k) + c
//! ```
//!
//! Source: Verhaegen (1994), *Identification of the deterministic part of MIMO state space models
//! given in innovations form from input-output data* (PO-MOESP). Rows of future inputs `U`, past
//! inputs and outputs `Z` and future outputs `Y` are factorised together,
//!
//! ```text
//! ⎡U⎤   ⎡L₁₁          ⎤ ⎡Q₁⎤
//! ⎢Z⎥ = ⎢L₂₁ L₂₂      ⎥ ⎢Q₂⎥        L₃₂ = U_n S_n V_nᵀ,  Γ = U_n S_n^½
//! ⎣Y⎦   ⎣L₃₁ L₃₂ L₃₃  ⎦ ⎣Q₃⎦
//! ```
//!
//! `A` and `C` follow from the shift structure of `Γ`, and `B`, `D`, `c` and the initial states by
//! linear least squares on the simulated output. Past data are the instruments: white *and*
//! coloured measurement noise leave `A` and `C` unbiased. When the shift makes an unstable `A`, a
//! block of zeros is appended to the shifted `Γ` (Maciejowski 1995), which makes it stable.
//!
//! | | type |
//! |---|---|
//! | fit | [`Subspace`] → [`SubspaceEstimate`] |
//! | known model | [`StateSpaceBias`] |
//! | run | [`StateSpaceSimulator`], a [`BiasModel`](fd_core::stage::BiasModel) |
//!
//! # When not to use it
//!
//! On line: it is a batch method, and its model does not re-train. For one channel of known order:
//! [`PredictionError`](crate::prediction_error::PredictionError) has less variance. The input
//! must excite twice the horizon.

mod fit;
mod hankel;
mod model;
mod response;
mod run;

pub use self::{
    fit::{Subspace, SubspaceEstimate},
    model::StateSpaceBias,
    run::StateSpaceSimulator,
};
