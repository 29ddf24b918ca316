//! On-line residual compensation and the decision whether a fault is present.
//!
//! ```text
//!  r ──▶ residual_compensation ──r* = r − μ̂──▶ detect ──statistic, threshold──▶ decide ──▶ fault, size
//! ```
//!
//! | Module | Question |
//! |------|----------|
//! | [`residual_compensation`] | What part of the residual is bias of the model, and not a fault? |
//! | [`detect`] | How far is the rest from normal? |
//! | [`decide`] | Is that a fault, since when, how large? |
//! | [`calibrate`] | Which threshold keeps a stated false-alarm rate? |
//! | [`evaluate`] | How good is the detector: false alarms, delay, smallest fault? |
//!
//! From a healthy log to an alarm with a promise about its rate:
//!
//! ```
//! use fd_compensate::{
//!     SampleRows,
//!     calibrate::{CalibrationPlan, FalseAlarms, calibrate},
//!     decide::{Debounce, Debouncing},
//!     detect::{Cusum, Spread, Standardizer},
//! };
//! use fd_core::stage::{Decision, DecisionRule, Detector, Evidence, Phase};
//!
//! // A residual that is uniform and hardly correlated; from sample 4000 on something adds 0.8 to it.
//! let mut r: Vec<f64> = (0..4100).map(|k| (f64::from(k).powi(2) * 0.618).sin()).collect();
//! r[4000..].iter_mut().for_each(|r| *r += 0.8);
//! let healthy = SampleRows::new(1, &r[..4000])?;
//!
//! // Scaled by the healthy residual; then its threshold is exceeded by a hundredth of healthy samples.
//! let scale = Standardizer::from_fault_free(healthy, Spread::StandardDeviation)?;
//! let mut detector = Cusum::<f64>::new(scale, 0.5, 1.0)?;
//! let wanted = FalseAlarms::PerSample { rate: 0.01 };
//! let found = calibrate(&mut detector, healthy, wanted, &CalibrationPlan::default())?;
//! let mut detector = detector.with_threshold(found.threshold)?;
//!
//! let mut rule = Debounce::new(1, Debouncing::consecutive(3))?;
//! let first = r.chunks(1).zip(0..).find_map(|(r_star, k)| {
//!     let verdict = detector.update(&[], r_star);
//!     match rule.decide(Evidence { k, phase: Phase::Compensating, verdict, r_star }) {
//!         Decision::Fault(fault) => Some(fault.since),
//!         _ => None,
//!     }
//! });
//! assert!(first.is_some_and(|since| since < 4050), "found at {first:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The parameter estimator and the bias model come from `fd-ident` or are any others that implement
//! [`Identifier`](fd_core::stage::Identifier) and [`BiasModel`](fd_core::stage::BiasModel); this crate knows
//! only the contracts.

pub mod calibrate;
mod count;
pub mod decide;
pub mod detect;
pub mod evaluate;
pub mod residual_compensation;
mod rows;
#[cfg(feature = "testing")]
pub mod testing;

pub use crate::rows::{DrivenRows, RowsError, SampleRows};
