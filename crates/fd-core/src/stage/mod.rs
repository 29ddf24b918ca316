//! The stages of a diagnosis, one trait each, in the order in which data meets them.
//!
//! All traits share four rules.
//!
//! 1. Signals cross as `&[T]` and `&mut [T]`; the caller owns every buffer.
//! 2. Methods that run per sample do not allocate and do not fail; failures belong to
//!    constructors and to [`Frame::new`](crate::Frame::new).
//! 3. Traits have no associated types, consts or generic methods, so each is usable as `dyn`.
//! 4. Each trait is implemented for `Box<S>`, so `dyn` is just another type.

use std::fmt::Debug;

use crate::{scalar::Scalar, snapshot::StateVisitor};

mod bias;
mod compensate;
mod decide;
mod detect;
mod forward;
mod identify;
mod plant;
mod residual;

pub use self::{
    bias::BiasModel,
    compensate::{Compensation, Compensator, Phase, Uncompensated},
    decide::{Decision, DecisionRule, Evidence, Fault},
    detect::{Detector, Verdict},
    identify::{GuardReport, Identifier},
    plant::Plant,
    residual::ResidualGenerator,
};

/// What every stage with a memory is besides its own trait: it can be printed, moved to another
/// thread, restarted, saved and restored.
pub trait Stage<T: Scalar = f64>: Debug + Send + Sync {
    /// Forgets all samples; the stage then behaves as when it was built.
    fn reset(&mut self);

    /// Shows every number that influences the future to `visitor`, always in the same order.
    ///
    /// Constants of the design (gains, thresholds) are not memory and are not visited.
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>);
}
