//! The command line `fdiag`, and its work on a user's own models and logs, as a library.
//!
//! [`run`] is the whole command line, for the binary and for the Python package.
//!
//! [`logs`] learns the bias of a residual from healthy logs and looks for faults in others.
//! [`fdiag::gap_study`] finds the unmodelled effect that separates a simulator from logs of the real system;
//! `fd_page` presents it.
//!
//! ```no_run
//! use fdiag::spec::PipelineSpec;
//! use fdiag_cli::logs::{LogStudy, Request};
//!
//! let request = Request {
//!     model: "examples/turbine.toml".into(),
//!     healthy: vec!["healthy.csv".into()],
//!     logs: vec!["today.csv".into()],
//!     columns: None,
//!     spec: PipelineSpec::default(),
//!     share_to_learn: 0.7,
//!     limits: fdiag::core::Limits::default(),
//! };
//! let (study, traces) = LogStudy::run(&request.read()?, &())?;
//! println!("{}", study.headline());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command-line tool")]

mod cli;
pub mod logs;

pub use crate::cli::run;
