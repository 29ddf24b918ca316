//! Canonical variates: the combinations of the past that foretell the future best are states of the plant.
//!
//! * **Equation.** With past `p(k) = [z(k−l+1); …; z(k)]`, `z = [u; y]`, and future `f(k) = [y(k+1); …; y(k+h)]`, the
//!   singular value decomposition `Σ_pp^−½ Σ_pf Σ_ff^−½ = U S Vᵀ` gives canonical variates `J p` with
//!   `J = Uᵀ Σ_pp^−½` of unit variance and correlations `S`. The first `n` are states: their T², the T² of the rest,
//!   and Q of `(I − J_nᵀ J_n) p`.
//! * **Source.** Larimore (1983, 1990); as a monitor Russell, Chiang and Braatz (2000). Their past ends one sample
//!   before the present one, here it ends with it, so that a fault is seen a sample earlier.
//! * **How many states** is [`States`]: a number, or Akaike's criterion for the one-step prediction of `y`
//!   (Larimore 1990).
//! * **Assumptions.** One operating point and noise; directions of the past in which nothing ever moved are left
//!   out. Future inputs are not projected out, as in Russell, Chiang and Braatz: with inputs that foretell themselves
//!   (feedback, slow set points) some states are those of the inputs.
//! * **Do not use** it with many channels and few samples: there are `l` times as many directions as channels, and
//!   the T² of the rest is then mostly noise that was learned by heart. Calibrate its limit on other logs.

mod design;
mod order;

pub use self::{
    design::{Cva, CvaDesign},
    order::States,
};
