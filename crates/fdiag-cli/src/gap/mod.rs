//! `fdiag gap`: a study of a user's simulator and logs as a page and tables.
//!
//! [`page`] and [`tables`] show what is in a [`GapStudy`](fdiag::gap_study::GapStudy); numbers, probabilities
//! and verdicts come from its typed report, and only words, units and pictures are made here.

mod page;
mod pictures;
mod tables;

pub use self::{page::page, tables::tables};
