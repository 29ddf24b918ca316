//! Scalar residual generators of the least order that has a wanted signature, in either time.
//!
//! * **Equation.** A parity vector `w = [w₀ … w_s]` with `w Γ = 0` and `w T_d = 0`, which exists from some least order
//!   `s` on, is a relation `Σ w_k (pᵏ y − Σ T …) = 0` between the signals and their first `s` derivatives (`p = s`) or
//!   shifts (`p = z`). Divided by any stable polynomial of degree `s` it is a proper filter with `s` states,
//!   `r = [Σ w_k pᵏ y − Σ (w T)_k pᵏ u] / Π (p − p_i)`, here in observer canonical form. No scalar generator with this
//!   signature has fewer states.
//! * **What it replaces.** Minimal dynamic covers on a null-space basis lead to filters of the same order; this way goes by
//!   singular values only, and serves continuous time too: a parity relation whose derivatives are filtered.
//! * **Source.** X. Ding, L. Guo and T. Jeinsch, "A characterization of parity space and its application to robust fault
//!   detection", IEEE TAC 44(2), 1999: parity vectors and observers of the same order; A. Varga, "Solving Fault Diagnosis
//!   Problems", 2017, section 5.2 (least-order synthesis), section 7.4 (by dynamic covers).
//! * **Assumptions.** The entries of the faults and disturbances are known; the plant may be unstable.
//! * **Do not use** it where noise matters: the least order leaves no freedom but the poles to filter it. Nor for orders
//!   far above ten, where the coefficients of a polynomial lose the place of its roots: take
//!   [`decouple`](crate::decouple), whose filters are longer and placed by states.

mod bank;
mod design;

pub(crate) use self::design::filter_of;
pub use self::{bank::LeastOrderBank, design::LeastOrderDesign};
