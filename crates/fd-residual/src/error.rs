//! What can go wrong while a residual generator is designed.

use fd_core::ShapeError;
use fd_model::{ModelError, fault::FaultError};
use thiserror::Error;

use crate::{analysis::Signature, rank::RankDecision};

/// No residual generator with the wanted properties exists, or the request is inconsistent.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DesignError {
    /// A matrix has the wrong size.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A model cannot be built or transformed, or is unstable where a stable one is needed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The outputs do not show a mode of the model, so no observer gain can move it.
    #[error(
        "the mode at {re} {im:+}i cannot be seen in the outputs: \
         [A - pI; C] has relative smallest singular value {distance:.1e}"
    )]
    Unobservable {
        /// Real part of the eigenvalue (1/s, or per sample for discrete models).
        re: f64,
        /// Imaginary part.
        im: f64,
        /// Smallest singular value of `[A − p I; C]` over the norm of `[A; C]`.
        distance: f64,
    },
    /// A fault is in no channel of the model.
    #[error(transparent)]
    Fault(#[from] FaultError),
    /// Too many or too few poles were asked for.
    #[error("an observer of {expected} states has {expected} poles, got {found}")]
    PoleCount {
        /// States of the model.
        expected: usize,
        /// Poles that were given.
        found: usize,
    },
    /// A complex pole was given without its conjugate, or a pole is not finite.
    #[error("pole {re} {im:+}i must be finite and come with its conjugate, equally often")]
    PoleConjugate {
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// A pole is repeated more often than an observer with full eigenvectors allows.
    #[error("pole {re} {im:+}i is wanted {multiplicity} times, but C has rank {rank} only")]
    PoleMultiplicity {
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
        /// How often it was given.
        multiplicity: usize,
        /// Number of independent outputs, the largest multiplicity possible.
        rank: usize,
    },
    /// The eigenvectors of the wanted poles are dependent to working precision.
    #[error("the wanted poles make eigenvectors of condition {condition:.1e}; spread the poles")]
    PlacementCondition {
        /// 2-norm condition number of the eigenvector matrix.
        condition: f64,
    },
    /// A speed factor is not a positive number.
    #[error("observer speed must be positive and finite, got {factor}")]
    Speed {
        /// Value that was given.
        factor: f64,
    },
    /// The window is too short for any parity relation with the wanted decoupling.
    #[error(
        "no parity relation of order {order}: {rows} rows of rank {rank} leave nothing \
         (smallest singular value {smallest:.1e} of what the data allow); take a longer window"
    )]
    NoParity {
        /// Window length minus one.
        order: usize,
        /// Rank of the matrix that has to be annihilated.
        rank: usize,
        /// Its rows.
        rows: usize,
        /// Its smallest singular value, relative as in a [`RankDecision`].
        smallest: f64,
    },
    /// No parity vector has the wanted signature.
    #[error("no parity vector of order 0 to {longest} has the signature {signature}")]
    NoSignature {
        /// One bit per fault: whether the residual has to react.
        signature: Signature,
        /// Longest order that was tried.
        longest: usize,
    },
    /// A residual was designed, and when it was looked at again it was not what was asked for.
    #[error(
        "residual {row} was to have the signature {wanted} and has {achieved}: the decision was too \
         near ({nearest})"
    )]
    NotAchieved {
        /// Residual, from 0.
        row: usize,
        /// One bit per fault, as asked for.
        wanted: Signature,
        /// One bit per fault, as found in the residual.
        achieved: Signature,
        /// The nearest decision behind the design.
        nearest: RankDecision,
    },
    /// A residual was designed to be free of an unknown input and is not.
    #[error("residual {row} lets {name} pass, which it was to be decoupled from ({nearest})")]
    NotDecoupled {
        /// Residual, from 0.
        row: usize,
        /// Name of the unknown input.
        name: String,
        /// The nearest decision behind the design.
        nearest: RankDecision,
    },
    /// Two models that no residual tells apart, or one that its own residual is not blind to (then both names agree).
    #[error(
        "the residual that is blind to the model \"{model}\" does not tell it from \"{other}\""
    )]
    SameModel {
        /// The model whose residual it is.
        model: String,
        /// The other one.
        other: String,
    },
    /// No filter makes of the faults what the reference does.
    #[error(
        "no residual is the wanted function of the faults: {missed:.1e} of the reference is missed, because faults that \
         it tells apart reach the outputs alike"
    )]
    NotMatched {
        /// Part of the reference that the nearest filter found misses.
        missed: f64,
    },
    /// A residual was designed so that noise has unit gain in some channels and none in the others, and it has not.
    #[error(
        "the noise has a gain of {loud:.3} in the channels where it should have one, and {quiet:.1e} where it should have \
         none: the design lost its accuracy"
    )]
    NotWhitened {
        /// Gain in the whitened channels.
        loud: f64,
        /// Gain in the others.
        quiet: f64,
    },
    /// A tolerance is no tolerance.
    #[error("a relative tolerance lies between 2.2e-16 and 1, got {tolerance}")]
    Tolerance {
        /// Value that was given.
        tolerance: f64,
    },
    /// A given parity vector does not annihilate the observability matrix.
    #[error("parity vector {row} leaves a relative {residue:.1e} of the initial state")]
    NotParity {
        /// Row of the given matrix, from 0.
        row: usize,
        /// `‖w Γ‖ / (‖w‖ ‖Γ‖)`.
        residue: f64,
    },
    /// An index lies outside what there is.
    #[error("{what} {index} does not exist, there are {count}")]
    Index {
        /// What is counted.
        what: &'static str,
        /// Index that was given, from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// There is another number of things than there has to be, or fewer than that.
    #[error("{what}: {expected} expected, got {found}")]
    Count {
        /// What is counted.
        what: &'static str,
        /// How many there have to be, or how many at least.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// The set of states that the bounds allow grows without end.
    #[error(
        "the set of possible states still grows after {samples} samples: the model is too uncertain for this gain \
         and this number of columns"
    )]
    Unbounded {
        /// Samples after which nobody waited any longer.
        samples: usize,
    },
    /// Something that must not be empty is.
    #[error("at least one {what} is needed")]
    Empty {
        /// What is missing.
        what: &'static str,
    },
    /// Every output is hidden by unknown inputs.
    #[error(
        "{inputs} unknown inputs hide all {outputs} outputs: no residual is free of them; \
         decouple fewer directions or measure more"
    )]
    NothingLeft {
        /// Unknown inputs to be decoupled.
        inputs: usize,
        /// Outputs of the plant.
        outputs: usize,
    },
    /// A fault reaches the outputs only where an unknown input does.
    #[error(
        "no solution: none of the {residuals} residuals that are free of the unknown inputs \
         reacts to the fault \"{fault}\", because it reaches the outputs only as they do"
    )]
    Undetectable {
        /// Name of the fault.
        fault: String,
        /// Residuals that are left after decoupling.
        residuals: usize,
    },
    /// The first condition of an unknown-input observer does not hold.
    #[error(
        "an unknown-input observer needs rank C E = rank E, but E has rank {rank_e} and C E \
         rank {rank_ce}: an unknown input reaches the outputs only through further states"
    )]
    HiddenDirection {
        /// Rank of `C E`.
        rank_ce: usize,
        /// Rank of `E`.
        rank_e: usize,
    },
    /// The second condition of an unknown-input observer does not hold.
    #[error(
        "the pair (C, A1) is not detectable: the invariant zero {re} {im:+}i from the unknown \
         inputs to the outputs stays as a pole of every unknown-input observer"
    )]
    UndecayingZero {
        /// Real part of the zero (1/s, or per sample for discrete models).
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// No row of the residual can be made a left eigenvector.
    #[error(
        "no left eigenvector W C of A - L C is free of the {inputs} unknown inputs: [C E, C A N] \
         has full row rank {rank}; a parity relation or a decoupled residual of higher order \
         may exist"
    )]
    NoEigenvector {
        /// Unknown inputs to be decoupled.
        inputs: usize,
        /// Rank of `[C E, C A N]`, equal to the number of outputs.
        rank: usize,
    },
}

/// A decomposition that does not converge.
pub(crate) fn no_convergence(what: &'static str, order: usize) -> DesignError {
    ModelError::NoConvergence { what, order }.into()
}
