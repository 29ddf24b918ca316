//! Many independent estimators at once: recursive least squares in SIMD lanes.
//!
//! Monte Carlo runs, units of a fleet, orders and hypotheses are many small independent estimators.
//! [`BatchRls`] keeps eight (`f64`) or sixteen (`f32`) of them side by side in memory, so that one instruction
//! serves them all, on the widest registers of the machine (AVX-512, AVX2, NEON, detected at run time) or in
//! plain scalar code.
//!
//! Each estimator does what [`UdRls`](crate::rls::UdRls) does, with forgetting of its own and the
//! same safeguards, with one kernel for all machines and scalars. Source: Bierman (1977), as there.
//!
//! # Which of the two kinds
//!
//! | constructor | a sample holds | use it when |
//! |---|---|---|
//! | [`BatchRls::arx`] | the inputs and the bias: `nu + 1` numbers | the equation is an ARX equation |
//! | [`BatchRls::new`] | the whole regressor and the target: `n + 1` numbers | the regressors are anything else |
//!
//! Prefer the first. It builds the regressors in the lanes, from past samples that each estimator keeps, which
//! saves memory traffic, the bottleneck of a large fleet. It also handles missing samples: after one, it waits
//! until its past is complete again.
//!
//! # How many estimators, how many samples
//!
//! *Lanes.* Estimators come in tiles of [`LaneScalar::WIDTH`], 8 of `f64` or 16 of `f32`: 64 bytes, one line of
//! the cache. A tile costs the same whether one of its lanes is used or all, so multiples of the width avoid
//! waste. With five parameters a tile takes 28 ns per sample, a single [`UdRls`](crate::rls::UdRls) 19 ns on
//! the stack and 33 ns on the heap: it pays from two units on. Lanes share instructions and nothing else. Each
//! may have its own forgetting ([`BatchRls::redesign`]), be frozen ([`BatchRls::freeze`]) or miss its sample.
//!
//! *Samples.* A [`SampleBlock`] holds several samples of each estimator, and one call to [`BatchRls::update`]
//! goes through all of them. An estimator of five parameters has about 30 numbers of state, which are loaded
//! and stored once per block. With some dozen samples per block this traffic matters little.
//!
//! *Parameters.* Up to 10 parameters, each number has an unrolled kernel of its own; up to 64, kernels are
//! shared. The cost grows with the square of the number, as for any recursive least squares.
//!
//! *Cores.* [`BatchRls::update_on_all_cores`] splits the tiles, not the samples, and gives the same
//! results to the bit. It pays from half a millisecond of work on, some hundred thousand updates.
//!
//! *Scalar.* `f32` is twice as fast and takes half the memory; see below for its limits.
//!
//! Measured rates on one machine are in `docs/results/throughput.md`: with five parameters, 268 million updates
//! a second in `f64` and 570 million in `f32` on one core.
//!
//! # Memory layout
//!
//! ```text
//! tile 0   row: setting 1 of estimators 0…7   row: setting 2   …   row: D₁   …   row: θ₁   …   row: U₁₂   …
//! tile 1   row: setting 1 of estimators 8…15  …
//! ```
//!
//! A row holds one number of each estimator of a tile, so a row fits a register, and the kernel reads like the
//! scalar one. Samples have the same layout: for each tile, for each sample, a row per column and one of
//! targets. Filling a block by [`SampleBlock::set`] scatters writes; where a whole sample of all units arrives
//! at once, [`SampleBlock::set_all`] writes rows.
//!
//! # Special cases
//!
//! | how | why |
//! |---|---|
//! | a missing sample is NaN; a skipped one has a zero direction and a zero error | no lane waits for another |
//! | a block starts with all samples missing | a unit that sends nothing needs no code |
//! | the trace of `P` is bounded from above, and computed when the bound says it may be too large | its limit costs one product per sample |
//! | after construction nothing allocates | a block is reused by [`SampleBlock::restart`] |
//!
//! [`BatchRls`] is a [`Stage`](fd_core::stage::Stage): all estimators can be reset, saved and restored
//! together. It is not an [`Identifier`](fd_core::stage::Identifier), because it answers per block and not per
//! sample; `fdiag::fleet` builds the compensation of many units on it.
//!
//! # Same results as one estimator alone
//!
//! The steps are the same except for rounding: products are fused with sums where the machine can, and the
//! order of sums differs. With `n` parameters each entry of `U` and `D` gets a relative error of a few `n ε`
//! more per sample in either form, and both forget it as they forget data: the factors stay positive, and
//! errors do not grow. Estimates agree to within some `n ε κ`, where `κ` is the condition number of the
//! weighted regressors; the tests of this crate check this lane by lane.
//!
//! # When not to use it
//!
//! For one estimator: [`UdRls`](crate::rls::UdRls) answers after each sample. For forgetting of kind
//! [`Bounded`](crate::rls::Forgetting::Bounded) or [`Resetting`](crate::rls::Forgetting::Resetting), which need
//! a different kind of step. For more than 64 parameters. For estimators that depend on each other.
//!
//! When excitation may stop, use [`Directional`](crate::rls::Forgetting::Directional), above all in `f32`: with
//! [`Exponential`](crate::rls::Forgetting::Exponential) the safeguards keep `P` bounded, but the condition
//! number grows until single precision cannot represent the estimate. Directional forgetting costs one division
//! and `n + 1` products more per sample.
//!
//! # A worked example
//!
//! Twenty units whose bias follows the input, `μ(k) = p μ(k−1) + u(k)`, each with its own pole. They send their
//! samples in blocks of 32; unit 7 loses some, and unit 3 is frozen after the first block.
//!
//! ```
//! use fd_ident::{
//!     arx::ArxOrders,
//!     batch::{BatchRls, LaneScalar, SampleBlock},
//!     rls::{Forgetting, RlsDesign},
//! };
//!
//! const UNITS: usize = 20;
//! let pole = |unit: usize| 0.5 + 0.02 * unit as f64;
//!
//! let design = RlsDesign::forgetting(Forgetting::Directional { lambda: 0.99 });
//! let mut fleet = BatchRls::<f64>::arx(ArxOrders::new(1, 1, 0), 1, UNITS, &design)?;
//! assert_eq!(UNITS.div_ceil(f64::WIDTH), 3, "three tiles, four lanes of the last unused");
//!
//! let mut mu = [0.0; UNITS];
//! let mut block = SampleBlock::new(1, UNITS, 32);
//! let mut at_first = [0.0; 2];
//! for first in [0, 32, 64] {
//!     // The same memory again, with every sample missing.
//!     block.restart(32);
//!     for step in 0..32 {
//!         let u = (0.3 * f64::from(first + step)).sin();
//!         for (unit, mu) in mu.iter_mut().enumerate() {
//!             *mu = pole(unit) * *mu + u;
//!             if unit != 7 || step % 8 != 0 {
//!                 block.set(unit, step as usize, &[u], *mu);
//!             }
//!         }
//!     }
//!     fleet.update(&block)?;
//!     if first == 0 {
//!         fleet.theta_into(3, &mut at_first);
//!         fleet.freeze(3, true);
//!     }
//! }
//!
//! // θ = [a, b] with a = −p: found by all, also by the one with the gaps.
//! let mut theta = [0.0; 2];
//! for unit in 0..UNITS {
//!     fleet.theta_into(unit, &mut theta);
//!     assert!((theta[0] + pole(unit)).abs() < 1e-4 && (theta[1] - 1.0).abs() < 1e-4, "{unit}");
//! }
//! // A gap costs two samples: the missing one, and the next, whose past is missing.
//! assert_eq!(fleet.guard(7).skipped, 3 * 4 * 2);
//! fleet.theta_into(3, &mut theta);
//! assert_eq!(theta, at_first, "a frozen estimator learns nothing");
//! # Ok::<(), fd_ident::batch::BatchError>(())
//! ```

mod design;
mod error;
mod estimators;
mod kernel;
mod layout;
mod past;
mod samples;
mod scalar;
mod tile;

pub use fd_numeric::lanes::{LaneScalar, Machine};

pub use self::{
    error::BatchError, estimators::BatchRls, samples::SampleBlock, scalar::BatchScalar,
};
