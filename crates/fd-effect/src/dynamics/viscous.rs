//! Viscous friction.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::each_site;
use crate::{Effect, Offers};

/// Friction `c v`; negative where the model has too much of it.
#[derive(Clone, Copy, Debug)]
pub struct ViscousFriction;

impl Effect for ViscousFriction {
    fn label(&self) -> &'static str {
        "viscous-friction"
    }

    fn family(&self) -> &'static str {
        "friction"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn dissipates(&self) -> bool {
        true
    }

    fn is_often_alike(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            let scale = at.force() / at.velocity();
            vec![
                sketch("linear")
                    .with_velocity(at)
                    .strength("c", "viscous", at.per_velocity(1), scale, [-1.0, 4.0])
                    .resist("viscous_friction", "c*v")
                    .starts([[0.05], [0.5]]),
            ]
        })
    }
}
