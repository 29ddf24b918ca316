//! Fits of a simulator to logs: nuisances, initial states and parameters of an effect at once.
//!
//! A fit minimises `Σ r² + Σ ((θ − θ₀)/s)²`: `r` are simulation errors in units of the noise, whitened when the
//! noise is coloured; the nuisance parameters `θ` (uncertain parameters and initial states) have a prior and a
//! box ([`Variable::known`]). Nothing is ever fitted to one-step predictions, which flatter every model.
//!
//! A free run is one [`Segment`] per log, or more where inputs were missing for too long; windows are many, each with its own
//! initial state. As an
//! initial state touches only its own segment, the slopes of all segments come from one simulation
//! and the normal equations are solved block by block.
//!
//! *When not to use:* a chaotic plant in free run has no useful slopes; use windows.

mod arrow;
mod cholesky;
mod columns;
mod descent;
mod error;
mod hidden_states;
mod holes;
mod layout;
mod levenberg;
mod log;
mod null;
mod plan;
mod problem;
mod screen;
mod variable;
mod weights;
mod within;

pub(crate) use self::{
    cholesky::Cholesky, descent::promised, levenberg::LONG, plan::shortest_window,
    problem::AT_A_TIME,
};
pub use self::{
    columns::Columns,
    error::FitError,
    layout::{Layout, LeastSquares, Linearization},
    levenberg::{Minimum, Search, minimise, minimise_all},
    log::Log,
    null::{NullFit, null_fit},
    plan::{Horizon, Plan, Segment},
    problem::Problem,
    screen::{Score, Surroundings},
    variable::Variable,
    weights::Weights,
};
