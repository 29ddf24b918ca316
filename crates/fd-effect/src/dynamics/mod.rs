//! Effects inside the plant: forces at its sites, and errors of its parameters.

mod constant_load;
mod coulomb;
mod coupling;
mod dependence;
mod drag;
mod end_stop;
mod event;
mod gravity;
mod hidden_store;
mod hysteresis;
mod mode;
mod overflow;
mod parameter;
mod periodic;
mod sites;
mod stiffness;
mod transmission;
mod viscous;
mod wander;

pub(crate) use self::parameter::mentions;
pub use self::{
    constant_load::ConstantLoad,
    coulomb::CoulombFriction,
    coupling::StateCoupling,
    dependence::ParameterDependence,
    drag::Drag,
    end_stop::EndStop,
    event::ParameterEvent,
    gravity::GravityLoad,
    hidden_store::HiddenStore,
    hysteresis::Hysteresis,
    mode::ResonantMode,
    overflow::Overflow,
    parameter::ParameterError,
    periodic::PeriodicForce,
    stiffness::{LinearStiffness, Stiffening},
    transmission::ElasticTransmission,
    viscous::ViscousFriction,
    wander::ParameterWander,
};
use super::Effect;

/// All effects inside the plant.
///
/// ```
/// assert_eq!(fd_effect::dynamics::all()[0].label(), "viscous-friction");
/// ```
#[must_use]
pub fn all() -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(ViscousFriction),
        Box::new(CoulombFriction),
        Box::new(Drag),
        Box::new(LinearStiffness),
        Box::new(Stiffening),
        Box::new(ConstantLoad),
        Box::new(GravityLoad),
        Box::new(PeriodicForce),
        Box::new(Hysteresis),
        Box::new(ResonantMode),
        Box::new(ElasticTransmission),
        Box::new(EndStop),
        Box::new(Overflow),
        Box::new(HiddenStore),
        Box::new(StateCoupling),
        Box::new(ParameterError),
        Box::new(ParameterDependence),
        Box::new(ParameterEvent),
        Box::new(ParameterWander),
    ]
}
