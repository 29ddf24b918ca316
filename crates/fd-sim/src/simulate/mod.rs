//! Simulators, which step through samples of inputs and return samples of outputs.
//!
//! [`Simulator`] is all that a diagnosis needs: a black box with inputs and outputs, and optionally parameters,
//! initial states and ports for forces. [`EquationSimulator`] runs a [`Model`](crate::model::Model) and shows
//! them all; [`BlackBox`] makes a simulator of any [`Plant`](fd_core::stage::Plant) or linear model.
//!
//! What is diagnosed is a [`Nominal`]: equations, or a [`Shell`] around any other simulator; or a
//! [`LoggedLoop`], of which the controller acts on what was logged.
//!
//! Integration is Runge-Kutta of order 4 on an even grid of sub-steps between samples. The length `h` of a
//! sub-step follows from the fastest eigenvalue of the linearised model, `h |λ| < 0.3`, unless the model states
//! it. At that bound the relative error of one step is `(h |λ|)⁵ / 120 = 2e-5`. *When not to use:* stiff models
//! whose fastest mode is of no interest need thousands of sub-steps.
//!
//! [`Simulator::simulate_many`] makes several runs through the same inputs. For equations they run side by side
//! in SIMD lanes, and the results are bit-identical to those of single runs: sixteen cost about as much as two
//! (more with powers and inverse functions, which are computed lane by lane). A fit computes all its slopes in
//! this way.
//!
//! Runs whose forces depend on what they show cannot be made in one go. [`Simulator::lock_step`] makes several of them
//! step by step beside each other, each driven by a [`Driven`]: a simulator that steps many lanes in one call then gets
//! one call per step, with the equations of the shells before and after it. One that makes whole runs only is asked for a
//! few of them until what drives it is what follows from its outputs ([`Simulator::foretell`]).
//!
//! A simulation that diverges is neither an error nor a panic: it is NaN from then on, and
//! [`Outcome::Diverged`] says since when.

mod as_tapes;
mod black_box;
mod delay_line;
mod difference_equation;
mod equations;
mod error;
mod flat;
mod follower;
mod jacobian;
mod limits;
mod linearize;
mod lock_step;
mod logged_loop;
mod logged_outputs;
mod native;
mod nominal;
mod one_by_one;
mod run;
mod shell;
mod simulator;
mod state_map;
mod timing;
mod walk;

pub(crate) use self::{as_tapes::as_tapes, one_by_one::lane_by_lane};
pub use self::{
    black_box::BlackBox,
    difference_equation::{Changes, DifferenceEquation},
    equations::EquationSimulator,
    error::SimulateError,
    follower::Follower,
    limits::check_limits,
    linearize::{OperatingPoint, linearize, linearize_discrete},
    lock_step::{Around, Driven, Settled},
    logged_loop::{Commands, LoggedLoop},
    native::NativeEffect,
    nominal::Nominal,
    run::{Outcome, Run, Tape},
    shell::{Shell, ShellSimulator},
    simulator::{Initial, Port, Simulator},
    state_map::StateMap,
    walk::walk,
};
