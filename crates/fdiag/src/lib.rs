//! Model-based fault diagnosis with on-line residual compensation.
//!
//! The facade of the workspace: the method crates under short names, pipelines described as data
//! ([`spec`]), the whole road from healthy logs to a diagnosis ([`road`]), its two uses - the engine
//! benchmark ([`engine`]) and a user's own logs ([`logs`]) - and reports ([`report`]). Many units at once are a [`fleet`].

pub mod blind;
pub mod compare;
pub mod engine;
pub mod fleet;
pub mod gap;
pub mod journal;
pub mod logs;
mod quantile;
pub mod report;
pub mod road;
pub mod spec;

pub use fd_compensate as compensate;
pub use fd_core as core;
pub use fd_gap;
pub use fd_ident as ident;
pub use fd_jetengine as jetengine;
pub use fd_model as model;
pub use fd_residual as residual;
