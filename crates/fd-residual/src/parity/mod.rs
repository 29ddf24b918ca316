//! Parity-space residuals `r = W (Y − T U)` over a sliding window of `s + 1` samples.
//!
//! * **Equation.** With `Y = [y(k−s); …; y(k)]` and `U` alike, `Y = Γ x(k−s) + T U`, where `Γ`
//!   stacks `C Aⁱ` and `T` holds the Markov parameters. Any `W` with `W Γ = 0` gives a residual
//!   that knows nothing of the state (Chow and Willsky 1984, eq. 10 to 14). Unknown inputs are
//!   decoupled by `W [Γ T_d] = 0`.
//! * **Not exact.** When no such `W` exists, or for several models at once, the left singular
//!   vectors of `[Γ₁ … Γ_N]` with the smallest singular values are the closest to orthogonal
//!   (Lou, Willsky and Verghese 1986).
//! * **Assumptions.** A linear model; stable or not makes no difference. The residual is zero by
//!   definition until the window is full.
//! * **Do not use** long windows on noisy outputs without looking at the fault-to-noise gap
//!   ([`analysis`](crate::analysis)): `W` differentiates. A slow filter behind it
//!   ([`FilteredDesign`](crate::weighted::FilteredDesign)) or an observer is smoother.

mod annihilate;
mod design;
mod run;
mod signature;
mod window;

pub use self::{
    annihilate::RankDecision,
    design::ParityDesign,
    run::{FixedWindow, Parity, Window},
};
pub(crate) use self::{
    annihilate::annihilators,
    window::{input_map, observability},
};
