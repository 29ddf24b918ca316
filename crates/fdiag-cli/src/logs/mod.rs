//! The road on a user's own model and logs: learn from the healthy ones, diagnose the others.

mod error;
mod named;
mod report;
mod study;

pub use self::{
    error::LogStudyError,
    named::NamedFault,
    study::{BiasSummary, LogResult, LogStudy, REPORT_VERSION, Request, SignalUnit, Traces},
};
