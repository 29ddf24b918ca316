//! Left eigenstructure assignment: the residual's own rows are made eigenvectors of the observer.
//!
//! * **Equation.** `x̂⁺ = A x̂ + B u + L ε`, `ε = y − C x̂ − D u`, `r = W ε`. When the rows of `W C`
//!   are left eigenvectors of `A − L C` and `W C E = 0`, then `W C (zI − A + L C)⁻¹ E = 0`: the
//!   disturbance does not reach the residual (Patton and Chen 1991, AIAA-91-2797; Chen and
//!   Patton 1999, theorem 4.2).
//! * **Assignability.** `w C` can be a left eigenvector for the pole `λ` when
//!   `w C (λI − A)` lies in the row space of `C`. As `w C` does, this is `w C A N = 0` for
//!   `C N = 0`, whatever `λ`: the rows `W` are the left null space of `[C E, C A N]`.
//! * **Deadbeat.** With `λ = 0` in discrete time, `r(k) = w y(k) − g y(k−1) − …` is a parity relation of order
//!   one (Patton and Chen 1991; the test compares the two).
//! * **Assumptions.** `E` is known; the modes that `L` cannot move decay.
//! * **Do not use** it when the error says that no such row exists: a longer
//!   [`parity`](crate::parity) relation or a [`decouple`](crate::decouple)d residual of higher
//!   order may. With `W C E` only nearly zero, nothing bounds what passes.

mod design;

pub use self::design::EigenstructureDesign;
