//! Residuals that are exactly free of unknown inputs, of the least order that a state-space
//! construction gives: a left null space of `[G_u G_d; I 0]`.
//!
//! * **Equation.** `ξ⁺ = Φ ξ + V B u + G (y − D u) + K r`, `r = W (y − D u) − M ξ`, where `ξ`
//!   estimates `V x` and `V A = Φ V + G C`, `V E = G F`, `W F = 0`, `W C = M V` for unknown
//!   inputs that enter by `E` into the states and by `F` into the outputs. `V` spans the
//!   smallest conditioned invariant subspace's annihilator, found by at most as many steps as
//!   there are states; its part that `M` does not show is left out, so `K` places every pole.
//! * **Source.** The parametrisation of all residual generators by a left null space: Ding and
//!   Frank (1991); Varga (2017), section 5.1. The invariant subspace: Basile and Marro (1969);
//!   Massoumnia (1986), unobservability subspaces.
//! * **Assumptions.** The entry directions are known. Neither stability nor observability of the
//!   plant is needed, nor `rank C E = rank E` as for an
//!   [unknown-input observer](crate::unknown_input).
//! * **Ranks** are decided in natural units ([`rank`](crate::rank)), where the rows of `V` and `W` are
//!   orthonormal; [`LeftNullSpace::nearest`] says how near the nearest decision was.
//! * **Do not use** it when the directions are only roughly known: what is not decoupled passes
//!   unweighted; take the [`optimal`](crate::optimal) room. Nor when the state estimate itself is
//!   wanted: only `V x` is estimated.

mod design;
mod invariant;
mod isolability;
mod verified;

pub(crate) use self::verified::{refuse_what_enters, refuse_what_passes};
pub use self::{
    design::{DecoupledDesign, LeftNullSpace},
    isolability::{isolability, isolability_within},
};
