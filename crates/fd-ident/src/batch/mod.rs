//! Many independent estimators at once: recursive least squares in the lanes of wide registers.
//!
//! Monte Carlo runs, units of a fleet, orders and hypotheses are many small estimators that know
//! nothing of each other. [`BatchRls`] keeps eight (`f64`) or sixteen (`f32`) of them side by side
//! in memory, so that one instruction serves them all, on the widest registers that the machine
//! has (AVX-512, AVX2, NEON, found at run time) or on none.
//!
//! Each estimator does what [`UdRls`](crate::rls::UdRls) does, with forgetting of its own and the
//! same safeguards, with one kernel for all machines and scalars. Source: Bierman (1977), as there.
//!
//! | how | why |
//! |---|---|
//! | a [`SampleBlock`] holds several samples of each estimator | memory is loaded and stored once per block, not per sample |
//! | [`BatchRls::arx`] makes regressors from input and bias where they are used | a fleet waits for memory, not for arithmetic |
//! | a missing sample is a NaN, a skipped one has no direction and no error | no lane waits for another |
//! | the trace of `P` is bounded from above, and computed when the bound says it may be too large | its limit costs one product per sample |
//!
//! # Same results as one estimator alone
//!
//! The steps are the same but for rounding: products are fused with sums where the machine can,
//! and sums are ordered otherwise. With `n` parameters each entry of `U` and `D` gets a relative
//! error of a few `n ε` more per sample in either form, and both forget it as they forget data: the
//! factors stay positive, errors do not grow. Estimates agree within some `n ε κ`, where `κ` is the
//! condition of the weighted regressors; the tests of this crate hold them to it, lane by lane.
//!
//! # When not to use it
//!
//! For one estimator: [`UdRls`](crate::rls::UdRls) answers after each sample. For forgetting of
//! kind [`Bounded`](crate::rls::Forgetting::Bounded) or
//! [`Resetting`](crate::rls::Forgetting::Resetting), which need a step of another shape. For more
//! than 64 parameters.
//!
//! When excitation may stop, forget by
//! [`Directional`](crate::rls::Forgetting::Directional), above all in `f32`: with
//! [`Exponential`](crate::rls::Forgetting::Exponential) the safeguards keep `P` bounded, but the
//! condition of the problem grows until single precision cannot hold the estimate. It costs one
//! division and `n + 1` products more per sample.

mod design;
mod error;
mod estimators;
mod kernel;
mod lanes;
mod machine;
mod past;
mod samples;
mod tile;

pub use self::{
    error::BatchError, estimators::BatchRls, lanes::LaneScalar, machine::Machine,
    samples::SampleBlock,
};
