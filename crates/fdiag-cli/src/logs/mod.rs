//! The road on a user's own model and logs: learn from the healthy ones, diagnose the others.

mod above;
mod error;
mod headline;
mod healthy;
mod material;
mod named;
mod report;
mod study;

pub use self::{
    above::AboveMaximum,
    error::LogStudyError,
    healthy::{LogDoubt, Void, VoidReason},
    material::{Material, Request, StudiedLog},
    named::NamedFault,
    study::{BiasSummary, LogResult, LogStudy, REPORT_VERSION, SignalUnit, Traces},
};
