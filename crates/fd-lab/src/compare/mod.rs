//! The tournament: every residual generator with every bias model and every detector, on the same
//! engines, at the same rate of false alarms.
//!
//! Thresholds of different detectors are in different units and promise different things, so all are
//! brought to one rate: each detector is scaled on healthy runs of its own engine, then its threshold is
//! multiplied by the factor at which the wanted share of fault-free runs of *other* engines alarms. What is found at
//! that factor on engines that neither saw is the result. For one engine of one type, as in a plant
//! with no sister, this is not the way to set a threshold: calibrate it on its own data.

mod comparison;
mod config;
mod cost;
mod defaults;
mod engines;
mod error;
mod family;
mod fault;
mod file_hash;
mod isolate;
mod markdown;
mod method;
mod named;
mod overall;
mod own;
mod plants;
mod report;
mod residuals;
mod result;
mod rounded;
mod run;
mod scenario;
mod scene;
mod share;
mod tally;
mod unit;
mod watch;

pub use self::{
    comparison::{Comparison, REPORT_VERSION},
    config::{CONFIG_VERSION, CompareConfig, Engines},
    error::CompareError,
    family::Family,
    fault::{FaultGrid, FaultKind, ProfileKind, Sizes},
    method::{Bias, Detector, Generator},
    overall::Overall,
    own::{OwnError, OwnFault, OwnPlant},
    result::{EntryName, EntryResult, FaultResult, IsolationResult, RocPoint, ScenarioResult},
    run::begin_anew,
    scenario::{Present, Scenario},
    share::Share,
};
pub(crate) use self::{
    own::OwnPlants,
    plants::{Ask, Plants, Runs},
};
