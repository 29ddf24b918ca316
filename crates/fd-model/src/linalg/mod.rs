//! What faer lacks: exponential, balancing, Schur form, Sylvester, checked solves.
//!
//! Everything runs on one thread: faer is built without its thread pool, so that its global
//! setting is sequential.

mod balance;
mod cayley;
mod eigenvalues;
mod exponential;
mod factor;
mod positive;
mod solve;
mod svd;

pub(crate) use self::{
    balance::balance,
    cayley::cayley,
    eigenvalues::{eigenvalues, require_decay},
    exponential::exponential,
    factor::smith_factor,
    positive::is_positive,
    solve::{identity_minus, solve, solve_right, symmetric},
    svd::svd,
};
