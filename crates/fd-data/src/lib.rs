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
