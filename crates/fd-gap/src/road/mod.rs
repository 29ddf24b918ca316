//! Several causes: one after another, each only if it improves forecasts, all refitted together.
//!
//! Real systems have several effects at once, most of them small. Where one cause does not bring a model down
//! to the noise, the best one is kept with its parameters adjustable, and the model with it is diagnosed again.
//! A cause is accepted if it closes a part of the held-out gap that is clearly more than nothing; the
//! road ends where nothing does, at the noise, or after so many causes. At the end each cause is taken out
//! again, with everything else refitted, and stays out if the forecasts do not miss it.
//!
//! *When not to use:* to find two causes in a log that one explains down to the noise, or that a pair does:
//! then [`diagnose`](crate::diagnose) has said all there is. Without held-out logs only evidence accepts, and
//! the list is as long as the evidence wishes.
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
