//! Model-based fault diagnosis with on-line residual compensation.
//!
//! The facade of the workspace: the method crates under short names, pipelines described as data ([`spec`]),
//! the way from healthy logs to a running diagnosis ([`training`]), and many units at once ([`fleet`]).
//! [`gap_study`] goes from a model file and logs to the report of a gap diagnosis. [`engine_plant`] makes the
//! jet engine a plant for gap diagnosis.

//!
//! A diagnosis needs a model, a spec with a line for each choice, and a healthy log:
//!
//! ```
//! use faer::mat;
//! use fdiag::{
//!     core::Heap,
//!     model::{
//!         Channel, Discrete, Inputs, SampleTime, Simulation, StateSpace,
//!         fault::{FaultProfile, FaultSpec, Site},
//!         signal::{Prbs, WhiteNoise},
//!     },
//!     spec::PipelineSpec,
//!     training::{Healthy, Trace, train},
//! };
//!
//! // What is believed of the plant, and what is there: 20 % more gain.
//! let ts = SampleTime::new(0.1)?;
//! let lag = |gain: f64| {
//!     StateSpace::new(mat![[0.9]], mat![[gain]], mat![[1.0]], mat![[0.0]], Discrete { ts })
//! };
//! let (model, plant) = (lag(0.1)?, lag(0.12)?.freeze::<f64, Heap>()?);
//! let inputs = Inputs::from_signals([(Channel::new("u", "1"), Prbs::new(9, 0.5, 1.0))], 2000, ts)?;
//! let run = |seed, faults| {
//!     let output_noise = vec![WhiteNoise::new(1e-3, seed).into()];
//!     let simulation = Simulation { output_noise, faults, ..Simulation::default() };
//!     simulation.run(&plant, &inputs, Channel::numbered("y", 1))
//! };
//!
//! let spec: PipelineSpec = toml::from_str(
//!     r#"
//!     generator = { kind = "observer", rate = 2.0 }
//!     bias.orders = { kind = "fixed", na = 2, nb = 3 }
//!     detector = { kind = "maximum", margin = 0.1 }
//!     rule = { raise = 3, out_of = 3 }
//!     "#,
//! )?;
//! let trained = train(&spec, &model, &[Healthy::split(&run(1, vec![])?, 0.7)])?;
//!
//! // From 100 s on the sensor drifts by 1e-3 a second: found within 20 s, and not before.
//! let drift = FaultSpec::add(Site::sensor(0), 100.0, FaultProfile::drift(1e-3));
//! let trace = Trace::of(&mut trained.compensated()?, &run(2, vec![drift])?)?;
//! let found = trace.first_alarm(0);
//! assert!(found.is_some_and(|k| (1000..1200).contains(&k)), "{found:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod engine_plant;
pub mod fleet;
pub mod gap_study;
pub mod spec;
pub mod training;
mod watcher;

pub use fd_compensate as compensate;
pub use fd_core as core;
pub use fd_data as data;
pub use fd_effect as effect;
pub use fd_gap as gap;
pub use fd_ident as ident;
pub use fd_jetengine as jetengine;
pub use fd_log as log;
pub use fd_model as model;
pub use fd_nonlinear as nonlinear;
pub use fd_residual as residual;
pub use fd_sim as sim;
pub use fd_sim::outside::{NoPrograms, forbid_programs};
pub use fd_structure as structure;

pub use crate::watcher::Watcher;
