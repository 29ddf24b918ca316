//! Diagnosis of the sim-to-real gap: where it lies, which effect causes it, how far it shrinks.
//!
//! | module | what it is for |
//! |---|---|
//! | [`quality`] | whether the log is good enough, and how much of it is noise |
//! | [`stretches`](mod@stretches) | the most informative stretches of a long log |
//! | [`fit`] | fits of a simulator to logs, and screening |
//! | [`evidence`] | how strongly a log speaks for a cause |
//! | [`shrink`] | how far a gap shrinks on data that the fit has not seen |
//! | [`diagnose`](mod@diagnose) | all of it, from a model, candidates and logs to an answer |
//! | [`few_runs`] | the same for a simulator that is expensive to run |
//! | [`inside`](mod@inside) | effects on signals inside a model |
//! | [`reading`] | whether the log is read as it is meant |
//! | [`locate`](mod@locate) | where the gap lies: output, side, equation, frequency, region, time |
//! | [`experiment`] | the experiment that would separate what this log cannot |
//! | [`calibrate`] | the expected confusion matrix of this log |
//! | [`ceiling`](mod@ceiling) | how much a black-box compensation could remove |
//!
//! A simulator, a log of the real system, and what may be missing:
//!
//! ```
//! use fd_effect::{EverySite, library};
//! use fd_gap::diagnose::{Case, Settings, Verdict, diagnose};
//! use fd_model::Record;
//! use fd_sim::{model::Model, scales::ReplayScales};
//!
//! let lag: Model = r#"
//! version = 1
//! kind = "equations"
//! name = "lag"
//! sample_time = 0.1
//! inputs = { u = { unit = "V" } }
//! outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
//! states = { x = { unit = "V", initial = 0.0, derivative = "u - x" } }
//! "#.parse()?;
//!
//! // In reality the amplifier cannot deliver more than 0.6 V.
//! let ts = lag.sample_time()?;
//! let u: Vec<f64> = (0..300).map(|k| (0.05 * f64::from(k)).sin() + 0.3).collect();
//! let mut x = 0.0;
//! let rows = u.iter().zip(0_u32..).map(|(u, k)| {
//!     // Uniform, and as wide as noise of 0.01 V.
//!     let noise = 0.0173 * ((f64::from(k).powi(2) * 0.618).sin().asin() / 1.5708);
//!     let y = x + noise;
//!     x = u.min(0.6) + (-0.1_f64).exp() * (x - u.min(0.6));
//!     ([*u], [y])
//! });
//! let log = Record::from_rows(lag.external_inputs(), lag.output_channels(), rows, ts)?;
//!
//! let mut effects = library();
//! effects.retain(|effect| ["input-saturation", "input-gain"].contains(&effect.label()));
//! let scales = ReplayScales::of(&lag, ts, &u, u.len())?;
//! let suspects = EverySite::new(effects, &lag, scales);
//! let case = Case { nominal: &lag, suspects: &suspects, logs: &[log], held_out: &[] };
//! let diagnosis = diagnose(&case, &Settings::default(), &())?;
//! assert_eq!(diagnosis.verdict, Verdict::Cause);
//! assert!(diagnosis.no_gap < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod calibrate;
pub mod ceiling;
pub mod diagnose;
pub mod estimate;
pub mod evidence;
pub mod experiment;
pub mod few_runs;
pub mod fit;
pub mod inside;
pub mod locate;
pub mod quality;
pub mod reading;
pub mod road;
pub mod shrink;
pub mod stretches;
mod together;
