//! Bias models that change with the operating point: local equations, blended.
//!
//! ```text
//! s(k) = s(k−1) + (u_i(k) − s(k−1)) / (1 + τ)            slow copy of one input
//! μ̂(k) = Σ_j w_j(s(k)) μ̂_j(k),   A_j(q) μ̂_j = B_j(q) u + c_j
//! ```
//!
//! with hat functions `w_j` over the centres of the regions: they are not negative, sum to 1, and at a centre
//! only its own model counts. Every local model always runs on its own past, so the blend is stable if each of
//! them is, however fast `s` moves. Source: the decoupled multiple model of Filev (1991), with local learning
//! as in Murray-Smith & Johansen (1997), *Multiple model approaches to modelling and control*, chapter 7.
//!
//! A region learns only from samples at which it is the nearest one; training one region
//! ([`RecursiveScheduled`], after [`Identifier::retrain`](fd_core::stage::Identifier::retrain)) leaves the
//! others unchanged, bit for bit.
//!
//! Take a constant term: the bias in a region is that *around* its centre.
//!
//! # When not to use it
//!
//! When `s` moves as fast as the dynamics of the bias: blending outputs then does not model the transition.
//! When the operating point is not visible in an input (a change of altitude, of health): train again instead.

mod model;
mod recursive;
mod regions;
mod run;

pub use self::{
    model::ScheduledModel,
    recursive::RecursiveScheduled,
    regions::{Regions, Scheduler},
    run::ScheduledSimulator,
};
