//! Structural analysis: what the equations of a model say about faults before any number is known.
//!
//! Which unknowns occur in which equation decides which faults can be detected and isolated at all, by which
//! equations, what another sensor would add, and in which order a residual is computed.
//!
//! | module | what it is for |
//! |---|---|
//! | [`model`] | equations, unknowns, known signals and faults, by hand |
//! | [`graph`] | matchings, the Dulmage-Mendelsohn decomposition |
//! | [`analysis`] | detectability and isolability, with restricted causality |
//! | [`redundancy`] | minimal overdetermined sets (MSO), test equation supports (MTES) |
//! | [`design`] | which sensors to add, which tests to choose |
//! | [`equations`] | structural models of model files with equations |
//! | [`generator`] | residual generators from minimal overdetermined sets |
//!
//! # When not to use it
//!
//! Structural results are generic: they hold for almost all values of the parameters and say nothing about
//! magnitudes. A fault that is structurally detectable may drown in noise or modelling errors; `fd-residual`
//! computes fault-to-noise gaps for linear models. Numerical coincidences (a term that cancels, two equations
//! that say the same) are not detected.
//!
//! ```
//! use fd_structure::{analysis::Causality, model::StructuralModel, redundancy::Supports};
//!
//! // A motor of which current and speed are measured.
//! let motor = StructuralModel::builder("motor")
//!     .equation("armature", ["di", "i", "w"], ["u"])
//!     .equation("rotor", ["dw", "i", "w"], [])
//!     .differential("i", "di")
//!     .differential("w", "dw")
//!     .equation("ammeter", ["i"], ["yi"])
//!     .equation("tachometer", ["w"], ["yw"])
//!     .fault("winding", "armature")
//!     .fault("bearing", "rotor")
//!     .fault("f_i", "ammeter")
//!     .fault("f_w", "tachometer")
//!     .build()?;
//!
//! let found = motor.isolability(Causality::Mixed);
//! assert_eq!(found.detectable, [true; 4]);
//! // Without any one of the four equations, the others can still be tested against each other.
//! assert_eq!(found.groups().len(), 4);
//! let tests = motor.test_supports(Supports::Minimal, 100);
//! assert_eq!(tests.sets.len(), 4);
//! # Ok::<(), fd_structure::model::StructureError>(())
//! ```

pub mod analysis;
pub mod design;
pub mod equations;
pub mod generator;
pub mod graph;
pub mod model;
pub mod redundancy;
