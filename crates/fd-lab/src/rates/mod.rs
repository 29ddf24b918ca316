//! Do stated rates of false alarms hold? A diagnosis is trained as a user trains it, on healthy logs of one plant with the
//! settings as they come, and then sees healthy runs that nothing was learned from.
//!
//! The rate is that of runs in which an alarm is raised, on average over plants, each with logs of its own: what a user
//! may expect who has such logs. That of one set of logs scatters about it.

mod detectors;
mod measure;

pub use self::{
    detectors::{Stated, detectors},
    measure::{Left, Measured, Plan, Rate, measure},
};
