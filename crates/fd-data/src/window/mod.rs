//! Residuals that are linear in a window: `r(k) = F [z(k−s); …; z(k)] + c` with `z = [u; y]`.
//!
//! Scores of principal components, canonical states and parity relations from data all have this form; what
//! they differ in is where `F` comes from. The residual is zero by definition until the window is full.
//!
//! * **Do not use** it for relations that a model gives: `fd_residual::parity` knows how exact they are.

mod design;
mod run;

pub(crate) use self::run::SlidingWindow;
pub use self::{design::WindowMapDesign, run::WindowMap};
