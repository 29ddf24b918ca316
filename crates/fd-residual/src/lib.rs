//! Residual generators, each of the one form `r = H_u u + H_y y` (Patton and Chen 1992, eq. 2).
//!
//! | Module | Residual | Choose it when |
//! |------|----------|----------------|
//! | [`simulation`] | `y − y_sim(u)` | the plant is stable and a model of any kind exists |
//! | [`observer`] | innovation of an observer | initial state and disturbances must be forgotten |
//! | [`parity`] | `W (Y − T U)` over a window | a deadbeat residual, designed by rank, is wanted |
//! | [`unknown_input`] | error of an observer that a disturbance does not reach | the directions of the disturbance are known or learned |
//! | [`decouple`] | all residuals without given inputs, of least order | only the residual matters, or the observer does not exist |
//! | [`eigenstructure`] | rows that are left eigenvectors of an observer | a deadbeat or first-order residual is wanted |
//! | [`optimal`] | whitened left null space | noise is modelled and sensitivity matters at every frequency |
//! | [`structured`] | a bank with a wanted structure matrix | faults are isolated by which residuals fire |
//! | [`directional`] | the Beard filter | faults are isolated by the direction of the residual |
//! | [`matching`] | a given function of the faults, exactly or as nearly as noise allows | residuals are to be the faults themselves, or to have a shape |
//! | [`least_order`] | one channel with as few states as its signature allows | residuals are to be simple, also in continuous time |
//! | [`model_detection`] | one residual per model, blind to that model | the question is which of several models the plant is |
//! | [`robust`] | a window that many models pass and faults do not | the plant is one of a family, and nothing tells which |
//! | [`scheduled`] | innovation of an observer that follows an operating variable | linear models along an operating range exist |
//! | [`adaptive`] | innovation of an observer that learns parameters | the modelling error is a drift of known parameters |
//! | [`estimation`] | the faults themselves, with an interval | the size of a fault is wanted, not only its presence |
//! | [`zonotope`] | innovation of an observer, over the most that bounded errors can make of it | no false alarm is allowed and everything has a bound |
//! | [`weighted`] | `W r` of any of these | channels are combined, scaled or filtered |
//! | [`bank`] | several of these side by side | faults are isolated by a set of residuals |
//! | [`form`] | any stable `H_u`, `H_y` | the generator was designed elsewhere |
//!
//! If the directions of an unknown input are not known, [`disturbance`] estimates them from perturbed models or
//! from healthy logs.
//!
//! Each design exposes its [`ResidualForm`], which [`analysis`] turns into design-time answers: which faults it
//! detects, how far they are above the noise, which signature it has. Answers that depend on ranks report how
//! near the [decision](rank) was, and take a tolerance that suits the accuracy of the model.
//!
//! ```
//! use faer::mat;
//! use fd_core::{Fixed, Frame, stage::ResidualGenerator};
//! use fd_model::{Discrete, SampleTime, StateSpace};
//! use fd_residual::{
//!     analysis::{UnknownInputs, fault_effects},
//!     observer::ObserverDesign,
//! };
//!
//! // A motor with its speed and current measured.
//! let domain = Discrete { ts: SampleTime::new(0.01)? };
//! let (a, b) = (mat![[0.98, 0.05], [-0.1, 0.7]], mat![[0.0], [0.3]]);
//! let (c, d) = (mat![[1.0, 0.0], [0.0, 1.0]], mat![[0.0], [0.0]]);
//! let motor = StateSpace::new(a, b, c, d, domain)?;
//!
//! // Design: an observer that forgets three times as fast as the motor does. Is it any good?
//! let design = ObserverDesign::faster(&motor, 3.0)?;
//! let sensors = UnknownInputs::none(&motor).sensor(&motor, 0)?.sensor(&motor, 1)?;
//! let effects = fault_effects(&design.form()?, &sensors.system(&motor)?)?;
//! assert!(effects.iter().all(|effect| effect.lasting));
//!
//! // Run: any scalar, sizes known to the compiler, nothing on the heap.
//! let mut observer = design.freeze::<f32, Fixed<2, 1, 2>>()?;
//! let mut r = [0.0; 2];
//! observer.step(Frame::new(observer.io(), 0, &[1.0], &[0.0, 0.25])?, &mut r);
//! assert_eq!(r, [0.0, 0.25]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod adaptive;
pub mod analysis;
pub mod bank;
pub mod decouple;
pub mod directional;
pub mod disturbance;
pub mod eigenstructure;
mod error;
pub mod estimation;
pub mod form;
mod kalman;
pub mod least_order;
pub mod matching;
mod matrix;
pub mod model_detection;
mod natural;
pub mod observer;
pub mod optimal;
pub mod parity;
pub mod rank;
pub mod robust;
pub mod scheduled;
pub mod simulation;
pub mod structured;
#[cfg(feature = "testing")]
pub mod testing;
pub mod unknown_input;
pub mod weighted;
pub mod zonotope;

pub use crate::{
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
};
