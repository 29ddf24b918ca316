//! What to measure, and which tests to run.

mod placement;
mod requirement;
mod selection;

pub use self::{
    placement::{PlacementError, Placements, Sensors},
    requirement::Requirement,
    selection::{Selection, select_tests},
};
