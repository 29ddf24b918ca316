//! The unscented Kalman filter: sigma points instead of slopes.
//!
//! * **Equations.** The points `x̂ ± √(n + κ) s_j`, with `s_j` the columns of the factor `S` and weights
//!   `1 / 2(n + κ)`, and `x̂` itself with the weight `κ / (n + κ)`, go through `f` and through `h`; their weighted
//!   means and deviations take the place of `f(x̂)`, `h(x̂)`, `F S` and `H S` in a square-root Kalman filter (Julier
//!   and Uhlmann 1997, eq. 9 to 12; van der Merwe and Wan 2001). Points are drawn again after the time update.
//! * **`κ`** must not be negative here: all weights are positive then, and no factor can be lost. `κ = 0` are the
//!   points of the cubature filter (Arasaratnam and Haykin 2009); `n + κ = 3` has the fourth moments of a
//!   normal law right.
//! * **Assumptions.** White, normal, independent noises; the law of the state stays near a normal one.
//! * **Do not use** it for models that are nearly linear within the spread of the estimate: it is then
//!   equivalent to the extended filter at the same cost. With many states the points lie `√n` spreads apart and
//!   may leave the model's region of validity: the residual is NaN there. For multimodal distributions use a
//!   [`particle`](crate::particle) filter.

mod design;
mod run;

pub use self::{design::UnscentedDesign, run::UnscentedKalman};
