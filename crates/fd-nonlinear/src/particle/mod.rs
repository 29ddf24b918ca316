//! The bootstrap particle filter: many states are drawn, propagated and weighted.
//!
//! * **Equations.** Each particle goes through `f` and gets process noise of its own; `r = y − Σ wᵢ h(xᵢ, u)`
//!   with the weights from before this sample; then `wᵢ ← wᵢ p(y | xᵢ)`, and when fewer than half of the
//!   particles count, `1/Σ wᵢ² < N/2`, they are resampled by their weights (Gordon, Salmond and Smith 1993,
//!   section 3; systematic resampling, Kitagawa 1996).
//! * **Seed.** The random numbers of a sample follow from the seed and the number of the sample, so the memory of
//!   the generator is a counter, and a restored filter continues to the bit.
//! * **Assumptions.** None on the law of the state; noises white and independent. The error falls with the root
//!   of the number of particles.
//! * **Do not use** it for more than a few states, where nearly all particles miss, nor without process noise,
//!   where copies never part; nor where a Kalman filter will do, which costs a hundredth. A hard fault makes all
//!   particles unlikely: the nearest few are kept, and the spread is too small for a while.

mod design;
mod run;

pub use self::{design::ParticleDesign, run::BootstrapFilter};
