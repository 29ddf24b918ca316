//! Residuals from data: what is normal is learned from healthy logs, and no model is needed.
//!
//! | room | what is normal | statistics | when |
//! |---|---|---|---|
//! | [`pca`] | the directions in which the channels move together | T², Q | many redundant channels near one operating point |
//! | [`pca`] with lags | the same of a window: dynamic PCA | T², Q | channels with memory |
//! | [`cva`] | the part of the past that foretells the future | T² of states and of the rest, Q | the same, with fewer states |
//! | [`parity`] | linear relations between inputs and outputs of a window | any detector's | inputs that excite; residuals in place of statistics |
//!
//! All of them look at one window of `[u; y]`, oldest sample first. What comes out is either a
//! [`Monitor`](monitor::Monitor), with statistics, limits and contributions of channels, or a
//! [`WindowMap`](window::WindowMap), whose residual is linear in the window and goes through the ordinary
//! pipeline. Neither allocates nor fails per sample, and both show their memory.
//!
//! Three sensors of one oscillation, the last of which reads too high later on:
//!
//! ```
//! use fd_core::{Frame, IoDims};
//! use fd_data::pca::PcaDesign;
//! use fd_model::{Channel, Record, SampleTime};
//!
//! let x = |k: usize| (0.1 * k as f64).sin();
//! let noise = |k: usize, sensor: usize| 0.01 * ((k * (7 + 6 * sensor)) as f64).sin();
//! let row = |k: usize| [x(k) + noise(k, 0), 2.0 * x(k) + noise(k, 1), x(k) - noise(k, 2)];
//! let y: Vec<f64> = (0..500).flat_map(row).collect();
//! let healthy = Record::new(vec![], Channel::numbered("y", 3), vec![], y, SampleTime::new(1.0)?)?;
//!
//! let learned = PcaDesign::default().learn(std::slice::from_ref(&healthy))?;
//! assert_eq!(learned.monitor().components(), 1);
//! let mut monitor = learned.monitor().freeze::<f64>()?;
//! let mut q = |k: u64, y: &[f64]| -> Result<f64, Box<dyn std::error::Error>> {
//!     let frame = Frame::new(IoDims { nu: 0, ny: 3 }, k, &[], y)?;
//!     Ok(monitor.observe(frame).ok_or("a window of one sample is always full")?.q)
//! };
//! let (normal, [a, b, c]) = (q(0, &row(500))?, row(501));
//! assert!(q(1, &[a, b, c + 0.5])? > 100.0 * normal);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What they share is what they cannot know: a state of the plant that the healthy logs did not visit looks
//! like a fault, and a fault that was there while they were written looks normal.

pub mod cva;
mod error;
pub mod limits;
pub mod monitor;
pub mod parity;
pub mod pca;
mod samples;
mod spectrum;
pub mod window;

pub use self::{error::DataError, samples::Scaling};
