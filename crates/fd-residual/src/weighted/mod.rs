//! Weighted residuals `r_w = W r` of any generator.
//!
//! * **Equation.** `H_u ← W H_u`, `H_y ← W H_y`; the scalar residual of Patton and Chen (1992,
//!   section 4) is `W = [1 1 1 1 1]` on the innovations of the jet engine's observer.
//!   [`WeightedDesign`] holds a constant matrix, [`FilteredDesign`] a stable filter `W(z)`.
//! * **Assumptions.** None: eq. (5) holds for `W H` whenever it holds for `H`.
//! * **Do not use** a weighting across channels of different units without scaling them first,
//!   nor one whose rows let faults cancel: check with [`analysis`](crate::analysis).

mod design;
mod run;

pub use self::{
    design::{FilteredDesign, WeightedDesign},
    run::{Filtered, Weighted},
};
