//! The blind test of the gap diagnosis.
//!
//! [`make`](fn@make) simulates plants with effects of our own making and writes what a user would
//! have: a model file and logs. What is true of them is sealed and lies elsewhere. [`run`](fn@run)
//! diagnoses the cases without it; [`score`](fn@score) opens it and counts.
//!
//! `docs/blind.md` describes the cases and how to use the three.

mod answer;
mod baselines;
mod conditions;
mod controller;
mod cost;
mod diagnose;
mod draw;
mod error;
mod excitation;
mod feature;
mod files;
mod kind;
mod laws;
mod logger;
mod logs;
mod make;
mod misreading;
mod oracle;
mod plants;
mod random;
mod recorder;
mod refit;
mod rival;
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
    answer::{Answer, Named, Reading, Share, Together, read_answers},
    baselines::{Baseline, Baselines},
    conditions::Conditions,
    controller::{Action, Controller},
    cost::Cost,
    error::BlindError,
    excitation::Shape,
    feature::Feature,
    files::Variant,
    kind::CaseKind,
    laws::{Origin, Place},
    logger::Logger,
    make::{Order, make},
    misreading::Misreading,
    rival::{Oracle, Rival},
    run::{ChooseSettings, Manner, run},
    score::{
        Bin, BySquares, Calibration, ClassScore, ClosedOf, Comparison, OfSeveral, Rate, Score,
        Verdict, score, score_open,
    },
    seal::SealKey,
    truth::{Effect, Truth},
};
