//! The engine benchmark: Patton & Chen's experiment, repeated over many perturbed engines.

mod benchmark;
mod config;
mod error;
mod example;
mod excitation;
mod files;
pub mod joined;
mod logs;
mod on_line;
mod pair;
mod range;
mod reality;
mod report;
mod study;
mod trial;
mod vector;
mod watch;

pub use self::{
    benchmark::Benchmark,
    config::{
        CONFIG_VERSION, EngineChoice, EngineConfig, FaultConfig, PlantConfig, ReductionConfig,
    },
    error::EngineStudyError,
    example::{Example, FaultyRun, Residuals, TrainingTrace},
    excitation::{FreshRun, TrainingRun},
    files::UserFiles,
    on_line::{
        Afterwards, Drift, InTraining, OnLine, OnLineConfig, OnLineSummary, Opened, TrainingFault,
        TrainingFaultSummary,
    },
    pair::Pair,
    range::Range,
    report::NamedPicture,
    study::{FaultSummary, REPORT_VERSION, Study, Summary},
    trial::{FaultOutcome, Trial},
};
pub(crate) use self::{
    benchmark::{Case, Draw},
    reality::Reality,
};
