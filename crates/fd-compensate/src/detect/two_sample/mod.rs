//! The last samples against the fault-free ones: two-sample tests on a sliding window.
//!
//! For each channel, with `n` samples in the window and `n₀` in the fault-free reference, both taken as
//! samples of unknown distributions,
//!
//! | [`SampleTest`] | Statistic | Threshold for independent Gaussian samples |
//! |---|---|---|
//! | [`Mean`](SampleTest::Mean) | `|x̄ − x̄₀| / (s_p √(1/n + 1/n₀))`, `s_p` the pooled deviation | Student's t, `n + n₀ − 2` degrees of freedom |
//! | [`Variance`](SampleTest::Variance) | `|ln (s² / s₀²)|` | the wider of the two tails of Fisher's F |
//! | [`Distribution`](SampleTest::Distribution) | `√(n n₀/(n + n₀)) · sup |F_n − F_n₀|` (Kolmogorov-Smirnov) | `c(α) = √(−ln(α/2)/2)`, any continuous distribution, large `n` |
//!
//! and the largest of all channels is the statistic. The mean finds shifts, the variance a sensor that goes
//! dead or noisy, the distribution either and changes of shape that leave both as they were.
//!
//! A window that is not yet full counts as normal (statistic 0).
//!
//! **Assumptions.** Independent samples for the thresholds of [`threshold`], which are per sample and
//! channel; windows overlap, so alarms come in runs. Residuals with memory make windows vary far more:
//! calibrate.
//!
//! **Not to be used** where the spread of a healthy residual follows the input: a loud input then looks like
//! a fault; see [`adaptive`](super::adaptive).

mod design;
mod run;

pub use self::{
    design::{SampleTest, kolmogorov_constant, threshold},
    run::TwoSample,
};
