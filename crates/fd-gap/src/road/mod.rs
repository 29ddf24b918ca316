//! Several causes: one after another, as long as they are believed together, all refitted together.
//!
//! Real systems have several effects at once, most of them small. Where one cause does not bring a model down
//! to the noise, the best one is kept with its parameters adjustable, and the model with it is diagnosed again.
//! A cause is accepted if the list with it is more probable than not and leaves less of held-out logs. The road ends
//! where no cause does that, at the noise, or after the given number of causes. At the end each cause is
//! removed in turn, with everything else refitted, and stays out if the forecasts get no worse.
//!
//! Near the noise evidence decides alone, and each cause is sought again beside all others. The same is tried far above
//! the noise where the list that is believed ends before it: no list of laws comes down to the noise, in held-out logs as
//! well, by chance, so such a list is the answer whatever one cause alone does.
//!
//! *When not to use:* to find two causes in a log that one explains down to the noise, or that a pair does:
//! then [`diagnose`](crate::diagnose) has already given the answer. Without held-out logs causes are accepted
//! by evidence alone, and the list may be too long.
//!
//! Forward selection with backward elimination (Efroymson 1960), with beliefs that held-out forecasts bound as the criterion
//! in place of an F-test: with a wrong model everything is significant. By evidence: floating search (Pudil, Novovičová and
//! Kittler 1994), which looks back before it goes on with what is not credible.

mod adjustable;
mod beside;
mod beyond;
mod by_evidence;
mod drive;
mod eliminate;
mod finish;
mod growth;
mod list;
mod milestone;
mod result;
mod to_the_noise;

pub use self::{
    drive::{Bounds, road},
    result::{End, Milestone, Road},
};
