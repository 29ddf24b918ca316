//! Which orders? Information criteria and held-out simulation, on the same rows for all.
//!
//! With `N` rows, `p` parameters and the mean squared one-step error `V` of each residual
//! channel, summed over the channels:
//!
//! | criterion | value | source |
//! |---|---|---|
//! | AIC | `N ln V + 2 p` | Akaike (1974) |
//! | `AICc` | `AIC + 2 p (p + 1)/(N − p − 1)` | Hurvich & Tsai (1989) |
//! | BIC | `N ln V + p ln N` | Schwarz (1978) |
//! | FPE | `ln V + ln (N + p)/(N − p)` | Akaike (1969), as its logarithm |
//! | held out | root mean square of `μ − μ̂` in *simulation* on other records, relative to that of `μ` | |
//!
//! The first four judge one-step prediction, but the compensation simulates: the last one is what
//! counts, and the table says when they disagree. All candidates are fitted to and judged on the
//! same rows, those that the widest candidate can use. A bias model often has a pole near a zero
//! (the one printed in Patton & Chen (1992) has), and the criteria are then tempted by a lower
//! order: compare the candidates by their responses, as [`OrderTable::verdict`] does.
//!
//! # When not to use it
//!
//! On noise-free data the criteria ask for ever more parameters, until `V` reaches the rounding
//! of the data; take the held-out simulation error then.

mod criteria;
mod problem;
mod select;
mod shared;
mod table;

pub use self::{
    criteria::Criterion,
    problem::{FitOrders, OrderProblem},
    select::{all_orders, paper_orders, select_orders},
    table::{OrderScore, OrderTable, Verdict},
};
