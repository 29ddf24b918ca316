//! The vocabulary of the workspace: frames, stages, and the pipeline that joins them.
//!
//! ```text
//! (u, y) ──Frame──▶ ResidualGenerator ──r──▶ Compensator ──r* = r − μ̂──▶ Detector ──▶ DecisionRule ──▶ Step
//! ```
//!
//! Every arrow is a slice of scalars or a small `Copy` struct. Every box is one trait in [`stage`].
//! [`Pipeline::step`] is the only place where the boxes meet. This crate defines the contracts and contains no
//! methods.
//!
//! | To | read |
//! |---|---|
//! | run a diagnosis | [`Pipeline`], [`MissingSamples`], [`Step`] |
//! | write a method of your own | [`stage`], then the one trait that it implements |
//! | bound what a file may claim | [`Limits`], [`memory`] |
//! | save and restore | [`stage::Stage`], [`Snapshot`] |
//! | write one implementation for stack and heap, `f32` and `f64` | [`Storage`], [`Scalar`] |
//!
//! A method is its arithmetic plus a few lines. This detector is a stage like those of the library:
//!
//! ```
//! use fd_core::{StateVisitor, stage::{Detector, Stage, Verdict}};
//!
//! /// The mean residual, old samples forgotten.
//! #[derive(Debug)]
//! struct MovingMean(f64);
//!
//! impl Stage for MovingMean {
//!     fn reset(&mut self) {
//!         self.0 = 0.0;
//!     }
//!
//!     fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
//!         visitor.reals("mean", std::slice::from_mut(&mut self.0));
//!     }
//! }
//!
//! impl Detector for MovingMean {
//!     fn residual_len(&self) -> usize {
//!         1
//!     }
//!
//!     fn update(&mut self, _u: &[f64], r: &[f64]) -> Verdict<f64> {
//!         self.0 += 0.1 * (r[0] - self.0);
//!         Verdict { statistic: self.0.abs(), threshold: 0.5 }
//!     }
//! }
//!
//! let mut detector: Box<dyn Detector> = Box::new(MovingMean(0.0));
//! let alarm = (0..100).find(|_| detector.update(&[], &[1.0]).alarm());
//! assert_eq!(alarm, Some(6)); // 1 − 0.9⁷ = 0.52
//! ```

mod dims;
mod error;
mod event;
mod frame;
mod limits;
mod linmap;
pub mod memory;
mod pipeline;
mod scalar;
mod sink;
pub mod snapshot;
pub mod stage;
mod storage;

#[cfg(feature = "testing")]
pub mod testing;
mod visitor;

pub use crate::{
    dims::{IoDims, Shape},
    error::{BuildError, FrameError, ShapeError},
    event::{Event, EventKind, Events},
    frame::Frame,
    limits::{Amount, LimitError, Limits, Resource},
    linmap::LinMap,
    pipeline::{DynPipeline, DynStages, MissingSamples, Pipeline, Stages, Step},
    scalar::Scalar,
    sink::Sink,
    snapshot::{Snapshot, SnapshotError},
    storage::{Buffer, Fixed, Heap, HeapMap, Storage},
    visitor::StateVisitor,
};
