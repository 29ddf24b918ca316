//! The laws that are injected into the plants: our own, not those of the library of the diagnosis.
//!
//! *Matched* laws are what a law of the library describes (but dry friction sticks, delays are
//! exact, hysteresis is a differential equation). *Mismatched* laws belong under a label of the
//! library and are none of its laws. *Withheld* laws belong under no label at all.

mod elsewhere;
mod force;
mod input;
mod law;
mod origin;
mod sensor;
mod withheld;

pub(super) use self::law::{Arriving, Law, Measured, Mechanism, Needs, Setting, Site};
pub use self::{law::Place, origin::Origin};

/// All laws.
pub(super) fn catalogue() -> Vec<Law> {
    let mut all = input::laws();
    all.extend(force::laws());
    all.extend(sensor::laws());
    all.extend(withheld::laws());
    all.extend(elsewhere::laws());
    all
}
