//! Parity-space residuals `r = W (Y − T U)` over a sliding window of `s + 1` samples.
//!
//! * **Equation.** With `Y = [y(k−s); …; y(k)]` and `U` alike, `Y = Γ x(k−s) + T U`, where `Γ` stacks `C Aⁱ`
//!   and `T` holds the Markov parameters. Any `W` with `W Γ = 0` gives a residual that does not depend on the
//!   state (Chow and Willsky 1984, eq. 10 to 14). Unknown inputs are decoupled by `W [Γ T_d] = 0`.
//! * **Not exact.** When no such `W` exists, or for several models at once, the left singular
//!   vectors of `[Γ₁ … Γ_N]` with the smallest singular values are the closest to orthogonal
//!   (Lou, Willsky and Verghese 1986).
//! * **Ranks** are decided in natural units, relative to what a change of the data could do
//!   ([`rank`](crate::rank)), so that they do not depend on the units of the model.
//! * **Assumptions.** A linear model; stable or not makes no difference. The residual is zero by
//!   definition until the window is full.
//! * **Do not use** long windows on noisy outputs without looking at the fault-to-noise gap
//!   ([`analysis`](crate::analysis)): `W` differentiates. A slow filter behind it
//!   ([`FilteredDesign`](crate::weighted::FilteredDesign)) or an observer is smoother.

mod design;
mod natural;
mod run;
mod signature;
mod window;

pub use self::{
    design::ParityDesign,
    run::{FixedWindow, Parity, Window},
};
pub(crate) use self::{
    natural::{NaturalPlant, NaturalWindow},
    signature::least_vector,
    window::{input_map, observability},
};
pub use crate::rank::RankDecision;
