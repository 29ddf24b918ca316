//! One residual generator for a whole sample of models: as little as possible of the healthy plants, as much as possible of
//! their faults.
//!
//! * **Equation.** Over a window, model `m` gives `v = [Y; U] = M_m ξ` with the covariance `A_m` when it is healthy, and a fault
//!   adds `T_f,m f` with the covariance `B_m`. The residual `r = w v` is scalar or a few rows; it has the variance `w A_m wᵀ`
//!   without and gains `w B_m wᵀ` with a fault.
//! * **Average case.** The largest of `w B̄ wᵀ / w Ā wᵀ`, of means over the models: a generalised eigenvalue problem, with as
//!   many rows as are wanted, each of unit variance on average.
//! * **Worst case.** The largest of `min_m w B_m wᵀ / max_m w A_m wᵀ`. Every choice of weights `λ`, `μ ≥ 0` with sum one
//!   gives an upper bound, the largest eigenvalue of `(Σ μ_m B_m, Σ λ_m A_m)`, because a mean is neither below the least nor
//!   above the largest. Weights are moved to the models that decide, and the best row is kept with the least bound:
//!   [`RobustDesign::worst_case`] says both, so that nobody has to believe that the search ended well.
//! * **Source.** X.-C. Lou, A. S. Willsky and G. C. Verghese, "Optimally robust redundancy relations for failure detection in
//!   uncertain systems", Automatica 22(3), 1986; S. X. Ding, "Model-based Fault Diagnosis Techniques", Springer, 2013,
//!   chapter 7 (the quotient); multiplicative weights: Y. Freund and R. E. Schapire, Games Econ. Behav. 29, 1999.
//! * **Assumptions.** Stable models, inputs and noise as white as their scaling says: give inputs in units of their
//!   range. A polytope is given by its corners; the worst case over them is not exactly that of the inside, because `M_m`
//!   is not linear in the model, so draw some points of the inside too.
//! * **Do not use** it where the models differ in the direction of a fault: what is suppressed is then the fault. If it is
//!   known on line where the plant is among the models, take [`scheduled`](crate::scheduled); if the bias can be learned,
//!   learn it.

mod design;
mod moments;
mod search;

pub use self::{
    design::{RobustDesign, RobustWindow, WorstCase},
    moments::FaultShape,
};
