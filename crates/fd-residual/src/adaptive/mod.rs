//! An observer that re-identifies parameters of the plant while it runs.
//!
//! * **Equation.** With `A(θ) = A + Σ θ_i ΔA_i` and `B(θ)` alike, `φ_i = ΔA_i x̂ + ΔB_i u`,
//!   `r = y − C x̂ − D u`, sensitivities `Υ_i⁺ = (A(θ̂) − L C) Υ_i + φ_i`, and a Kalman filter for
//!   the random walk of `θ` with the regressor `C Υ`:
//!   `x̂⁺ = A(θ̂) x̂ + B(θ̂) u + L r + Υ⁺ (θ̂⁺ − θ̂)` (Zhang 2002, eq. 5, in discrete time by Guyader
//!   and Zhang 2003). The idea of a residual that is robust because the model follows the plant is
//!   that of Frank, Ding and Wochnik (1991), which Patton and Chen (1992) compare with.
//! * **Assumptions.** The modelling error *is* a change of these parameters, and the inputs excite
//!   them. The given gain keeps `A(θ) − L C` stable for all `|θ_i|` up to the bound; only `θ = 0`
//!   is checked.
//! * **Do not use** it where faults grow slowly: the parameters explain them away, and the residual
//!   returns to zero while the fault is still there. How fast is set by `drift`; with `drift = 0`
//!   it learns ever more slowly. Nor for errors of order or nonlinearity, which no parameter
//!   describes: the estimates then wander with the operating point. The
//!   [`form`](crate::GeneratorDesign::form) is that of `θ = 0`, before anything is learned.

mod design;
mod run;

pub use self::{
    design::{AdaptiveDesign, ParameterShift},
    run::{AdaptiveObserver, ParameterNoise},
};
