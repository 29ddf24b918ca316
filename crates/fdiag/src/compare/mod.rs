//! The tournament: every residual generator with every bias model and every detector, on the same
//! engines, at the same rate of false alarms.
//!
//! Thresholds of different detectors are in different units and promise different things, so all are
//! brought to one rate: each detector is scaled on healthy runs of its own engine, then its threshold is
//! multiplied by the factor at which the wanted share of fault-free runs of *other* engines alarms. What is found at
//! that factor on engines that neither saw is the result. For one engine of one type, as in a plant
//! with no sister, this is not the way to set a threshold: calibrate it on its own data.

mod config;
mod cost;
mod defaults;
mod error;
mod fault;
mod isolate;
mod report;
mod result;
mod run;
mod scene;
mod share;
mod tally;
mod unit;
mod watch;

pub use self::{
    config::{
        Bias, CONFIG_VERSION, CompareConfig, Detector, Engines, Generator, Present, Scenario,
    },
    error::CompareError,
    fault::{FaultGrid, FaultKind, ProfileKind, Sizes},
    result::{
        Comparison, EntryName, EntryResult, FaultResult, IsolationResult, Overall, REPORT_VERSION,
        RocPoint, ScenarioResult, SizeResult,
    },
    run::Watcher,
    share::Share,
};
