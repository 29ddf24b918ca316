//! What faer lacks: exponential, balancing, Schur form, Sylvester, checked solves.
//!
//! Everything runs on one thread: faer is built without its thread pool, so that its global
//! setting is sequential.

mod balance;
mod blocks;
mod cayley;
mod eigenvalues;
mod exponential;
mod factor;
mod pencil;
mod positive;
mod schur;
mod solve;
mod stein;
mod svd;
mod sylvester;

pub(crate) use self::{
    balance::balance,
    blocks::{beside, diagonal, lower, stack},
    cayley::Cayley,
    eigenvalues::{eigenvalues, require_decay},
    exponential::exponential,
    factor::{SmithFactors, smith_factors},
    pencil::{compress_rows, generalised_eigenvalues},
    positive::is_positive,
    schur::RealSchur,
    solve::{identity_minus, solve, solve_right, symmetric},
    stein::Stein,
    svd::{singular_values, svd},
    sylvester::sylvester,
};
