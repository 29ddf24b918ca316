//! Residual generators from a minimal overdetermined set: which equation is the residual, and in which order the others are
//! solved.
//!
//! All equations of the set but one determine its unknowns, block by block; the one that is left is then a residual, zero
//! but for noise, modelling errors and faults (Frisk, Åslund and Krysander 2009, sequential residual generators).
//! [`StructuralModel::sequence`](crate::model::StructuralModel::sequence) finds the order and what it asks for: integrals,
//! derivatives, or both. [`EquationModel::residual`](crate::equations::EquationModel::residual) makes a generator that
//! runs, if states need only be integrated.
//!
//! # When not to use it
//!
//! A generator with states integrates from the initial values of the model, and forgets a wrong one as fast as its part of
//! the plant does: not at all for an integrator, and never for an unstable plant. Then an observer is what is
//! wanted (`fd-residual`, on a linearised model). Derivatives are not taken numerically: noise decides what comes of it, and how
//! much smoothing is right is not in the structure. Blocks that need an iteration may have several solutions; the one
//! near the last is followed.

mod design;
mod guess;
mod invert;
mod newton;
mod run;
mod sequence;

pub use self::{
    design::{GeneratorError, How, Residual, Solve},
    invert::solve_for,
    run::{RunningResidual, StepError},
    sequence::{Flow, Sequence, SequenceError, Step},
};
