//! The blind test of the gap diagnosis.
//!
//! [`make`](fn@make) simulates plants with effects of our own making and writes what a user would
//! have: a model file and logs. What is true of them is sealed and lies elsewhere. [`run`](fn@run)
//! diagnoses the cases without it; [`score`](fn@score) opens it and counts.
//!
//! `docs/blind.md` describes the cases and how to use the three.

mod answer;
mod baselines;
mod diagnose;
mod draw;
mod error;
mod excitation;
mod laws;
mod make;
mod oracle;
mod plants;
mod random;
mod refit;
mod run;
mod scales;
mod score;
mod seal;
mod simulate;
mod strength;
mod truth;

#[cfg(test)]
mod tests;

pub use self::{
    answer::{Answer, Named, Share, read_answers},
    baselines::{Baseline, Baselines},
    error::BlindError,
    excitation::Shape,
    laws::{Origin, Place},
    make::{Order, make},
    oracle::{Oracle, Rival},
    run::{Progress, progress, run},
    score::{Bin, BySquares, Calibration, ClosedOf, Rate, Score, Verdict, score, score_open},
    seal::SealKey,
    truth::{CaseKind, Effect, Truth},
};
