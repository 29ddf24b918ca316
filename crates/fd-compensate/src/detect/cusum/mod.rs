//! Two-sided tabular cumulative sum (Page 1954), channel by channel.
//!
//! ```text
//! z = (r − m) / σ,   C⁺ ← max(0, C⁺ + z − k),   C⁻ ← max(0, C⁻ − z − k),   statistic max(C⁺, C⁻)
//! ```
//!
//! The reference value `k` is half the shift to be found, in standard deviations; the threshold `h`
//! sets the average run length (ARL) between false alarms. The sum keeps growing while a fault lasts,
//! which finds small faults at the price of a delay. It is *not* restarted after an alarm; the
//! debounced rule clears when the sum has come down.
//!
//! [`average_run_length`] is exact for independent `N(shift, 1)` samples and a start from zero: the
//! one-sided integral equation (Page 1954; Brook & Evans 1972 is its Markov-chain form)
//!
//! ```text
//! L(s) = 1 + L(0) Φ(k − shift − s) + ∫₀ʰ L(x) φ(x + k − shift − s) dx
//! ```
//!
//! is solved by Nyström's method on Gauss-Legendre nodes, and both sides are joined by
//! `1/L = 1/L⁺ + 1/L⁻` (Kemp 1961), which is exact for equal `h` and `k` on both sides.
//!
//! **Assumptions.** Known `m` and `σ`; independent Gaussian samples if `h` comes from
//! [`threshold_for`]. Positively correlated residuals alarm far more often: calibrate.
//!
//! **Not to be used** where the residual drifts slowly without a fault (a bias model frozen at
//! another operating point): the sum integrates that too.

mod design;
mod run;

pub use self::{
    design::{average_run_length, threshold_for},
    run::Cusum,
};
