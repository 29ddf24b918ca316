//! The plants of the blind test, in our own right-hand sides: nothing of the simulator that the
//! diagnosis uses is used here, except to read names and numbers from the model files.

mod drives;
mod elsewhere;
mod engine17;
mod equations;
mod inner;
mod looped;
mod mechanics;
mod plant;
mod process;

pub(super) use self::{
    inner::{Inner, inner},
    looped::{Looped, STABLE, Tuning, UNSTABLE, looped},
    plant::{Physics, Plant},
};
use super::kind::CaseKind;

/// All plants.
pub(super) const ALL: [Plant; 11] = [
    mechanics::MASS_SPRING_DAMPER,
    mechanics::PENDULUM,
    mechanics::CART_POLE,
    mechanics::CART_POLE_BALANCED,
    drives::DC_DRIVE,
    drives::DC_DRIVE_CLOSED_LOOP,
    drives::TWO_MASS_DRIVE,
    process::TANKS,
    process::TWO_INPUT,
    process::TWO_SPOOL_ENGINE,
    engine17::ENGINE17,
];

/// Plants of logs as people have them only.
const ELSEWHERE: [Plant; 4] =
    [elsewhere::SERVO, elsewhere::STANDING_PENDULUM, elsewhere::LEVITATION, elsewhere::TWO_FILTERS];

/// The plant of a name.
pub(super) fn plant(name: &str) -> Option<&'static Plant> {
    ALL.iter().chain(&ELSEWHERE).find(|plant| plant.name == name)
}

/// The plants of a kind of case.
pub(super) fn of_kind(kind: CaseKind) -> Vec<&'static Plant> {
    let looped = |all: &'static [Looped]| all.iter().map(|looped| looped.plant).collect();
    match kind {
        CaseKind::Unstable | CaseKind::UnstableNone => looped(&UNSTABLE),
        CaseKind::Loop | CaseKind::LoopNone => looped(&STABLE),
        CaseKind::Inside => {
            ALL.iter().chain(&ELSEWHERE).filter(|plant| !inner(plant).is_empty()).collect()
        }
        // A loop of the model is no matter of these classes, and the states of the large engine
        // are not those of its model.
        kind if !kind.is_plain() => {
            let others = ["dc-drive-closed-loop", "cart-pole-balanced", "engine17"];
            ALL.iter().filter(|plant| !others.contains(&plant.name)).collect()
        }
        _ => ALL.iter().collect(),
    }
}
