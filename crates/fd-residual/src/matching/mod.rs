//! Residuals that are given functions of the faults: `r = M_r f`, exactly or as nearly as noise allows.
//!
//! * **Exact.** `Q [G_u G_d G_f; I 0 0] = [0 0 M M_r]`: a left null space `Q₁` takes out `u` and `d`, and `Q₂ R_f = M M_r`
//!   is solved by inverting independent rows and columns of `R_f = Q₁ G_f`. What the inverse would need of derivatives, of
//!   modes that grow and of modes slower than wanted goes into `M`, a diagonal of filters: lags for zeros at infinity, and
//!   for a slow zero `z` a factor `(s − z)/(s + …)` that mirrors it in the line of the wanted rate. Several faults whose
//!   entries are dependent can be matched when the reference asks for nothing that depends on their difference.
//! * **Approximate.** With noise the distance `‖M [M_r 0] − Q [G_f G_w]‖∞` is made least over all stable `Q`: the two-block
//!   problem. It is the H-infinity filtering problem of estimating `M_r f` from `R_f f + R_w w`; for each level `γ` the
//!   filter comes from one Riccati equation with an indefinite quadratic term, and the least `γ` by bisection. With
//!   `γ = ∞` it is the H2 (Kalman) filter.
//! * **Looked at again.** An exact design computes `Q G_f − M M_r` over frequency and is refused when that is not rounding; an
//!   approximate one reports the norm that its filter has, next to the lower bound that the search left.
//! * **Source.** A. Varga, "Solving Fault Diagnosis Problems", Springer, 2017, sections 5.6 and 5.7 (procedures EMM and AMM),
//!   example 5.13; K. M. Nagpal and P. P. Khargonekar, "Filtering and smoothing in an H-infinity setting",
//!   IEEE TAC 36(2), 1991.
//! * **Assumptions.** The entries of the faults are known and the reference is stable. States that no input, disturbance or fault
//!   moves and that die out do so in the residual, too: an exact design is not blind to what they begin with.
//! * **Do not use** the exact design with noise on the outputs: an inverse amplifies it. Nor where only the presence of a fault
//!   matters: a reference costs sensitivity that [`optimal`](crate::optimal) keeps.

mod approximate;
mod exact;
mod filter;
mod inverse;
mod stable;

pub use self::{
    approximate::{ApproximateMatching, MatchingNorm},
    exact::ExactMatching,
};
