//! Model-based fault diagnosis with on-line residual compensation.
//!
//! The facade of the workspace: the crates of methods under short names, pipelines described as data
//! ([`spec`]), the whole way from healthy logs to a diagnosis ([`training`]), and many units at once
//! ([`fleet`]). The jet engine as a subject of gap diagnosis is [`engine_plant`], the one place that knows
//! both siblings.

pub mod engine_plant;
pub mod fleet;
pub mod gap_study;
pub mod spec;
pub mod training;

pub use fd_compensate as compensate;
pub use fd_core as core;
pub use fd_effect as effect;
pub use fd_gap as gap;
pub use fd_ident as ident;
pub use fd_jetengine as jetengine;
pub use fd_log as log;
pub use fd_model as model;
pub use fd_residual as residual;
pub use fd_sim as sim;

/// The example of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
