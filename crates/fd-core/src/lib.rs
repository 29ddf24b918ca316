//! The vocabulary of the workspace: frames, stages, and the pipeline that joins them.
//!
//! ```text
//! (u, y) ──Frame──▶ ResidualGenerator ──r──▶ Compensator ──r* = r − μ̂──▶ Detector ──▶ DecisionRule ──▶ Step
//! ```
//!
//! Every arrow is a slice of scalars or a small `Copy` struct. Every box is one trait in
//! [`stage`]. [`Pipeline::step`] is the only place where the boxes meet. This crate holds
//! contracts, never a method.

mod dims;
mod error;
mod event;
mod frame;
mod linmap;
mod pipeline;
mod scalar;
mod sink;
pub mod snapshot;
pub mod stage;
mod storage;

#[cfg(feature = "testing")]
pub mod testing;

pub use crate::{
    dims::{IoDims, Shape},
    error::{BuildError, FrameError, ShapeError},
    event::{Event, EventKind, Events},
    frame::Frame,
    linmap::LinMap,
    pipeline::{DynPipeline, DynStages, MissingSamples, Pipeline, Stages, Step},
    scalar::Scalar,
    sink::Sink,
    snapshot::{Snapshot, SnapshotError, StateVisitor},
    storage::{Buffer, Fixed, Heap, HeapMap, Storage},
};
