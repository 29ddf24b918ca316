//! Several causes: one after another, each only if it improves forecasts, all refitted together.
//!
//! Real systems have several effects at once, most of them small. Where one cause does not bring a model down
//! to the noise, the best one is kept with its parameters adjustable, and the model with it is diagnosed again.
//! A cause is accepted if the part of the held-out gap that it closes is clearly above zero. The road ends
//! where no cause does that, at the noise, or after the given number of causes. At the end each cause is
//! removed in turn, with everything else refitted, and stays out if the forecasts get no worse.
//!
//! *When not to use:* to find two causes in a log that one explains down to the noise, or that a pair does:
//! then [`diagnose`](crate::diagnose) has already given the answer. Without held-out logs causes are accepted
//! by evidence alone, and the list may be too long.
//!
//! Forward selection with backward elimination (Efroymson 1960), with held-out forecasts as the criterion in
//! place of an F-test: with a wrong model everything is significant.

mod adjustable;
mod beside;
mod by_evidence;
mod by_forecasts;
mod drive;
mod eliminate;
mod finish;
mod list;
mod milestone;
mod result;

pub use self::{
    drive::road,
    result::{End, Milestone, Road},
};
