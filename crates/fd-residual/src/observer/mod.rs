//! Observer-based residuals: the innovation of a Luenberger observer.
//!
//! * **Equation.** `x̂(k+1) = A x̂ + B u + L r`, `r(k) = y − C x̂ − D u`, so
//!   `[H_u H_y] = [−D I] − C (zI − A + L C)⁻¹ [B − L D, L]`.
//! * **Gain.** Given; by robust pole placement ([`place_poles`]: Kautsky, Nichols and Van Dooren
//!   1985, with the complex-pair step of Tits and Yang 1996); by the stationary Kalman filter; or
//!   the Beard filter `L = (A + σI) C⁺` when there are as many outputs as states.
//! * **Assumptions.** A linear model; every mode that is moved must be visible in the outputs.
//!   [`Observer`] can also correct a nonlinear [`Plant`](fd_core::stage::Plant) with a constant
//!   gain; the form then belongs to its linearisation.
//! * **Do not use** a fast observer to find slow faults: `H_y` then passes a sensor fault only
//!   while it changes, and `‖H_y(1)‖` falls with the gain (see
//!   [`analysis`](crate::analysis)). With unmeasured disturbances of known direction, decouple
//!   them ([`parity`](crate::parity)).

mod design;
mod observable;
mod place;
mod run;
mod visible;

pub use self::{
    design::ObserverDesign,
    place::{Placement, place_poles},
    run::Observer,
    visible::ErrorPoles,
};
pub(crate) use self::{
    observable::check_observable,
    visible::{entry_ranks, natural, place_visible, pole_of_rate, rank, visible_part_of},
};
