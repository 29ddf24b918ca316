//! On-line residual compensation and the decision whether a fault is present.
//!
//! ```text
//!  r ──▶ residual_compensation ──r* = r − μ̂──▶ detect ──statistic, threshold──▶ decide ──▶ fault, size
//! ```
//!
//! | Room | Question |
//! |------|----------|
//! | [`residual_compensation`] | What part of the residual is bias of the model, and no fault? |
//! | [`detect`] | How far is the rest from normal? |
//! | [`decide`] | Is that a fault, since when, how large? |
//! | [`calibrate`] | Which threshold keeps a stated rate of false alarms? |
//! | [`evaluate`] | What is the detector worth: false alarms, delay, smallest fault? |
//!
//! The parameter estimator and the bias model are those of `fd-ident` or any other that
//! implement [`Identifier`](fd_core::stage::Identifier) and
//! [`BiasModel`](fd_core::stage::BiasModel); this crate knows only the contracts.

pub mod calibrate;
mod count;
pub mod decide;
pub mod detect;
pub mod evaluate;
pub mod residual_compensation;
mod rows;
#[cfg(feature = "testing")]
pub mod testing;

pub use crate::rows::{DrivenRows, RowsError, SampleRows};
