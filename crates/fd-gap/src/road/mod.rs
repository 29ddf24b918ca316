//! Several causes: a set that grows as long as its causes are believed together, all fitted together.
//!
//! Real systems have several effects at once, most of them small. Where one cause does not bring a model down to the noise,
//! what can be added to it is sought beside it, in one fit with it.
//!
//! Far above the noise each law explains a part of the gap, and no single one may explain half of it: three axes that rub
//! have three frictions. So the set grows first, by what forecasts best, as long as that takes its part of what is left; and
//! then each law is judged by how often it beats what was tried in its place, and how much it explains of what all others
//! leave. As few as are more probable than not together are believed. At the end each cause is removed in turn, with everything
//! else refitted, and stays out if the forecasts get no worse.
//!
//! Near the noise evidence decides alone, and each cause is sought again beside all others. What has grown down to there goes
//! on so: no set of laws comes down to the noise, in held-out logs as well, by chance, so such a set is the answer whatever
//! one cause alone does.
//!
//! *When not to use:* to find two causes in a log that one explains down to the noise, or that a pair does:
//! then [`diagnose`](crate::diagnose) has already given the answer. Without held-out logs causes are accepted
//! by evidence alone, and the list may be too long.
//!
//! Forward selection with backward elimination (Efroymson 1960), with beliefs that held-out forecasts bound as the criterion
//! in place of an F-test: with a wrong model everything is significant. By evidence: floating search (Pudil, Novovičová and
//! Kittler 1994), which looks back before it ends.

mod by_evidence;
mod by_forecasts;
mod elimination;
mod floating;
mod result;
mod selection;
mod stepwise;
mod to_the_noise;

pub use self::{
    result::{CauseList, End, ListedCause},
    stepwise::{Bounds, road},
};
