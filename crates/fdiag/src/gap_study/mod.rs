//! Which unmodelled effect separates a simulator from logs of the real system: from files to a report.
//!
//! [`GapStudy::run`] reads a model and logs, diagnoses them with [`fd_gap`], and puts the complete result into
//! one [`Report`]. Everything that presents it (a page, tables, JSON, another language) reads the report;
//! [`words`] turns its types into plain language.

mod attempt;
mod automatic;
mod black_box;
mod budget;
mod calibrated;
mod data;
mod each;
mod error;
mod findings;
mod follow;
mod followed;
mod found;
mod further;
mod headline;
mod law;
mod log_finding;
mod log_part;
mod long;
mod memory;
mod only;
mod patched;
mod pause;
mod read;
mod report;
mod request;
mod said;
mod simulator_check;
mod sparing;
mod study;
mod subject;
mod traces;
mod whole;
pub mod words;

pub use fd_gap::diagnose::ControllerSees;

pub use self::{
    automatic::automatic_settings,
    budget::Budget,
    calibrated::{CalibratedModel, calibrate, calibrate_on},
    each::{Answered, CauseInLog, Compared, ComparedCause, LogAnswer, MeanStrength},
    error::GapError,
    follow::follow,
    law::Law,
    log_finding::{LogDefect, LogFinding, SimulatorDefect, TimeBaseDefect},
    log_part::{LogPart, Pace, Role},
    memory::Memory,
    patched::PatchedModel,
    report::{
        HorizonKind, HorizonSource, Inputs, REPORT_VERSION, Report, StudySettings, Timing, schema,
    },
    request::{HeldOutChoice, HorizonChoice, Named, Request, ResampleChoice, StartsChoice},
    simulator_check::{Cost, SimulatorCheck},
    sparing::Sparing,
    study::GapStudy,
    subject::Subject,
    traces::{Drive, Signals, Trace},
    whole::{Whole, Window},
};
