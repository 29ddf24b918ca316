//! Options beyond plain least squares, for residuals with noise.
//!
//! Equation-error least squares (the paper's, [`ArxFit`](crate::arx::ArxFit)) assumes noise that
//! is white *after* it went through `1/A`. Measurement noise is not: it sits in the regressor and
//! pulls the poles towards the origin, the more the faster the sampling. The remedies, in the
//! order in which to try them:
//!
//! | remedy | idea | when not to use it |
//! |---|---|---|
//! | [`Prefilter`] | filter input and bias by the same stable filter; the equation stays the same, the noise shrinks | when the dynamics reach into the band of the noise |
//! | [`decimate`] | average blocks of samples; poles move away from 1 | the model then lives on the slower time base, so the diagnosis must too |
//! | [`Sriv`] | refined instrumental variables | noise-free data, or too little of it: plain least squares is then better |
//!
//! None of them is on by default.

mod decimate;
mod prefilter;
mod sriv;

pub use self::{
    decimate::decimate,
    prefilter::Prefilter,
    sriv::{Sriv, SrivEstimate},
};
