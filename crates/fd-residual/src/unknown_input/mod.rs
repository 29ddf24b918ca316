//! Unknown-input observers: full state estimates that unmeasured disturbances do not reach.
//!
//! * **Equation.** `z⁺ = F z + T B u + K (y − D u)`, `x̂ = z + H (y − D u)`,
//!   `r = y − D u − C x̂`, for `x⁺ = A x + B u + E d`, with `H = E (C E)⁺`, `T = I − H C`,
//!   `A₁ = T A`, `F = A₁ − K₁ C`, `K = K₁ + F H` (Chen, Patton and Zhang 1996, eq. 6 to 10;
//!   Chen and Patton 1999, section 3.2). Then `T E = 0` and the error obeys `e⁺ = F e`.
//! * **Conditions.** `rank C E = rank E`, and `(C, A₁)` detectable: the invariant zeros from `d`
//!   to `y` decay. Both are checked, and named in the error.
//! * **Assumptions.** `d` enters the states only, along known directions `E`; where they are not
//!   known, [`disturbance`](crate::disturbance) finds the best ones.
//! * **Do not use** it for a fault that enters along `E`, which is decoupled as well; when as many
//!   directions as outputs are decoupled, nothing is left. When only the residual is wanted and a
//!   condition fails, [`decouple`](crate::decouple) needs less.

mod design;

pub use self::design::UnknownInputObserver;
