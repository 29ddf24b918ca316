//! Model-based fault diagnosis with on-line residual compensation.

pub mod report;
