//! Experiments, which no user of the library links: what the methods gain, and how often they are right.
//!
//! | module | question |
//! |---|---|
//! | [`engine`] | what does residual compensation gain on 1000 perturbed engines? |
//! | [`compare`] | which method wins where, at the same rate of false alarms? |
//! | [`rates`] | do healthy runs alarm as often as was stated? |
//! | [`blind`] | how often is the gap diagnosis right on cases whose truth is sealed? |
//! | [`engine_gap`] | does it name the cause that an engine was given? |
//! | [`journal`] | finished pieces of work, so that a killed run can resume |
//!
//! Every experiment maps a configuration to a result, with all random draws seeded. Patton and Chen's
//! experiment, on two of its thousand engines:
//!
//! ```
//! use fd_lab::engine::{Benchmark, EngineConfig};
//!
//! let config = EngineConfig { seeds: 2, ..EngineConfig::default() };
//! let study = Benchmark::new(config)?.study(&())?;
//! assert_eq!((study.trials.len(), study.failed.len()), (2, 0));
//! // Compensation makes the largest fault-free residual several times smaller.
//! assert!(study.summary.fault_free_ratio.median > 5.0, "{:?}", study.summary.fault_free_ratio);
//! # Ok::<(), fd_lab::engine::EngineStudyError>(())
//! ```

mod black_box;
pub mod blind;
pub mod compare;
pub mod engine;
pub mod engine_gap;
mod hex;
pub mod journal;
pub mod rates;
