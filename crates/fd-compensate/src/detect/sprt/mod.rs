//! Wald's sequential probability ratio test, started again whenever it accepts the healthy hypothesis.
//!
//! ```text
//! z = (r − m) / σ,   S ← S + δ (z − δ/2),   S ≤ ln A: healthy, S ← 0,   S > ln B: alarm
//! ln A = ln β/(1 − α),   ln B = ln (1 − β)/α
//! ```
//!
//! `S` is the logarithm of the likelihood ratio of a mean of `δ` standard deviations against zero, for each
//! channel, upwards and downwards; the statistic is the largest (Wald 1947, chapters 3 and 7). Of all tests
//! with the error probabilities `α` (a test that ends in a false alarm) and `β` (a test that misses `δ`) it
//! needs the fewest samples on average. Like the [cumulative sum](super::cusum), of which it is the forerunner
//! with the lower boundary at zero, it is not started again after an alarm: it comes down by itself.
//!
//! `α` is the share of *tests*, not of samples; [`operating_characteristic`] turns it into run lengths. With
//! `P(s)` the probability of an alarm from `S = s`, `N(s)` the expected samples to the end, and `f` the density
//! of a step,
//!
//! ```text
//! N(s) = 1 + ∫ N(x) f(x − s) dx,   P(s) = Pr(step > ln B − s) + ∫ P(x) f(x − s) dx   over ln A … ln B
//! ```
//!
//! are solved by Nyström's method on Gauss-Legendre nodes. A restarted test alarms after `N(0) / P(0)` samples
//! on average, exactly, because each start is as the first (Wald's identity). Wald's own approximations neglect
//! the overshoot of the boundaries.
//!
//! **Assumptions.** Known `m` and `σ`; independent Gaussian samples for all that is said of error
//! probabilities. Positively correlated residuals alarm more often: calibrate.
//!
//! **Not to be used** for faults much smaller than `δ/2`: they look healthy, test after test.

mod design;
mod run;

pub use self::{
    design::{ErrorProbabilities, Operating, operating_characteristic},
    run::{Sides, Sprt},
};
