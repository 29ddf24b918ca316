//! Something that nobody has written down, beside an explanation: where it acts, how strong it is, and how strong the
//! noise is beside it.
//!
//! Every place of the plant where something may act (forces, state equations, sensors) gets a disturbance: a signal with
//! knots, independent from knot to knot, of a size that the log decides by its evidence (type II maximum likelihood,
//! `MacKay` 1992; a latent force, Rogers & Friis 2022; the discrepancy of Kennedy & O'Hagan 2001). Its size zero is the free
//! run; a large one follows the log.
//!
//! *When not to use:* where the explanation is down to the noise already: there is nothing to be sized.

mod responses;
mod size;

pub(super) use self::size::{Beside, beside};
