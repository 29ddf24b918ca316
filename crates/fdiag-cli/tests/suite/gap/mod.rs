//! `fdiag gap` as a user meets it: what it says, writes and refuses.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

mod angles;
mod answers;
mod clocks;
mod desk;
mod each;
mod engine;
mod inside;
mod long;
mod own_effects;
mod random;
mod refusals;
mod schema;
mod uneven;
