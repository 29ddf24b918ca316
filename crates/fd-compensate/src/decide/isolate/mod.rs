//! Detection, isolation and estimation as one decision with its confidence.
//!
//! After a [debounced](super::Debounce) alarm the mean `r̄` of the residual since the first alarm is compared
//! with what each hypothesis allows. In units of the fault-free noise, with `n` samples of integrated
//! autocorrelation time `τ`,
//!
//! ```text
//! z = W (r̄ − m),   Wᵀ W = Σ⁻¹,   1/ν = τ/n + ε² ‖z‖²/c,   E = ν ‖z‖²,   E_h = ν ‖Q_hᵀ z‖²
//! ln p(z | h) = −E/2 + s E_h / (2 (1 + s)) − ½ p_h ln (1 + s),   s = E / p_h
//! ```
//!
//! with `c` channels. Hypothesis `h` confines `z` to the `p_h` directions `Q_h`: one for a known signature
//! `W g`, as many as responding channels for a row of a [structure matrix](Effect::Responds), all for *none of
//! these*, none for *no fault at all*. Within them `z` has a Gaussian prior of the size observed (empirical
//! Bayes), so that units and strength favour no hypothesis and one that allows more is penalised for it (the
//! logarithm). `ε` is how far a signature may be off, relative to its length; it keeps a small error of the
//! model from ruling out every hypothesis once `n` is large. Bayes' rule with the prior weights turns these
//! into probabilities; the most probable hypothesis is named if it reaches [`Isolation::naming`].
//!
//! A size with a signature is `ŝ = aᵀ z / aᵀ a`, `a = W g`, in `ŝ ± q / √(ν aᵀ a)` with the normal quantile `q` of
//! [`Isolation::coverage`]: if it is this fault.
//!
//! **Assumptions.** One fault at a time, whose effect has settled (see [`Isolation::settling`]); fault-free
//! noise as in the calibration data; Gaussian means.
//!
//! **Not to be used** to tell faults apart whose signatures are proportional: each is then as likely as the
//! other, and neither is named. In particular, a scalar residual names a fault only by prior weight.

mod design;
mod run;

pub use self::{
    design::{Candidate, Effect, FaultFree, Isolation},
    run::IsolatingDebounce,
};
