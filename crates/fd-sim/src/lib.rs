//! Simulators that can be patched: equations as text, linear models, black boxes in a shell of equations.
//!
//! | module | what it is for |
//! |---|---|
//! | [`equation`] | expressions as text, as trees and as bytecode |
//! | [`model`] | model files made of such expressions |
//! | [`simulate`] | the contract of a simulator, and its implementations |
//! | [`outside`] | simulators that are separate programs |
//! | [`stand_in`] | linear models of simulators that are expensive to run |
//! | [`scales`] | magnitudes of all signals in a simulation |
//! | [`patch`] | effects spliced into a model, which stays a model |
//!
//! A cart as text is run; then friction is added, and it is run again and printed:
//!
//! ```
//! use fd_sim::{
//!     equation::Expr,
//!     model::{Model, Parameter},
//!     patch::Patch,
//!     simulate::{EquationSimulator, Simulator},
//! };
//!
//! let cart: Model = r#"
//! version = 1
//! kind = "equations"
//! name = "cart"
//! sample_time = 0.1
//! parameters = { m = { unit = "kg", value = 2.0 } }
//! inputs = { u = { unit = "N" } }
//! states = { v = { unit = "m/s", initial = 0.0, derivative = "u/m" } }
//! outputs = { speed = { unit = "m/s", value = "v" } }
//! sites = { rail = { unit = "N", enters = { v = "1/m" }, velocity = "v" } }
//! "#.parse()?;
//!
//! // One newton for a second.
//! let mut simulator = EquationSimulator::<f64>::at(&cart, cart.sample_time()?)?;
//! let mut y = [0.0; 11];
//! simulator.simulate(&cart.nominal(), &cart.initial(), &[1.0; 11], &mut y);
//! assert!((y[10] - 0.5).abs() < 1e-12);
//!
//! // The same model with a force at its site is again a model.
//! let mut patch = Patch::of(&cart);
//! patch.add_parameter(Parameter::new("d", "N s/m", 4.0));
//! patch.add_force("rail", "friction", Expr::parse("-d*v")?)?;
//! let braked = patch.finish()?;
//! let mut simulator = EquationSimulator::<f64>::at(&braked, braked.sample_time()?)?;
//! simulator.simulate(&braked.nominal(), &braked.initial(), &[1.0; 11], &mut y);
//! // v = u/d (1 − e^(−d t/m)); Runge-Kutta of order 4 is exact to 1e-4 at the steps that it takes.
//! assert!((y[10] - 0.25 * (1.0 - (-2.0_f64).exp())).abs() < 1e-4);
//! assert!(braked.to_string().contains("friction = \"-d*v\""));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod equation;
pub mod model;
pub mod outside;
pub mod patch;
pub mod scales;
pub mod simulate;
pub mod stand_in;
mod workers;
