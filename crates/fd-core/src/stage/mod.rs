//! The stages of a diagnosis, one trait each, in the order in which data meets them.
//!
//! ```text
//! Frame ──▶ ResidualGenerator ──r──▶ Compensator ──r*──▶ Detector ──statistic──▶ DecisionRule
//!                 │                   ├─ Identifier      learns θ while training
//!                 └─ Plant            └─ BiasModel       simulates μ̂ from u and θ afterwards
//! ```
//!
//! A [`Pipeline`](crate::Pipeline) consists of the four in the upper row. The three below are building blocks
//! that some implementations use: an observer steps a [`Plant`]; the compensator of `fd-compensate` joins an
//! [`Identifier`] with a [`BiasModel`]. A generator without a plant, or a compensator without an identifier, is
//! just as valid.
//!
//! # Four rules that all traits share
//!
//! 1. *Signals cross as slices.* Inputs are `&[T]`, results are written to `&mut [T]`. The caller owns every
//!    buffer and has given it the length that the stage asked for (`residual_len()`, `theta_len()`, …). A stage
//!    writes all of it, every time, and keeps no reference to it.
//! 2. *What runs per sample neither allocates nor fails.* Sizes, ranges and convergence are checked by
//!    constructors, missing values by [`Frame::new`](crate::Frame::new). When a sample arrives, everything has
//!    been checked.
//! 3. *Every trait works as `dyn`*: no associated types or consts, no generic methods.
//! 4. *Each trait is implemented for `Box<S>`*, so `Box<dyn Detector>` is just another detector.
//!
//! No trait mentions a matrix type, and no stage knows about another one.
//!
//! # Three ways to choose a stage
//!
//! ```text
//! detector: Cusum::new(…)?                       static: inlined, sizes known to the compiler
//! detector: Box::new(Cusum::new(…)?)             dynamic: one virtual call per sample
//! detector = { kind = "cusum", reference = 0.5 } a line of a spec, read by `fdiag::spec`
//! ```
//!
//! The first two need nothing but an implementation of the trait. The third needs a variant in the enum of
//! `fdiag::spec`, because a file can only name methods that are compiled in.
//!
//! # Before you publish an implementation
//!
//! Call the shared tests of `fd_core::testing` (feature `testing`) from a test of your own: a reset stage
//! repeats itself, and a restored one continues bit for bit. One forgotten field breaks both, and no other test
//! would notice.

mod bias;
mod compensate;
mod decide;
mod detect;
mod forward;
mod identify;
mod memory;
mod plant;
mod residual;

pub use self::{
    bias::BiasModel,
    compensate::{Compensation, Compensator, Phase, Uncompensated},
    decide::{Decision, DecisionRule, Evidence, Fault},
    detect::{Detector, Verdict},
    identify::{GuardReport, Identifier},
    memory::Stage,
    plant::Plant,
    residual::ResidualGenerator,
};
