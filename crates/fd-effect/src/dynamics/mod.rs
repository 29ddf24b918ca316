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
mod stiffness;
mod transmission;
mod viscous;
mod wander;

use fd_sim::model::Model;
use fd_sim::scales::{ForceScale, ReplayScales, SignalScale};

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
use super::{Effect, Offers, Reason, Sketch, units::per};

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

/// Beginning and length, as parts of the log, of what is there between two times, from which to start.
pub(crate) const BETWEEN: [[f64; 2]; 6] =
    [[0.1, 0.2], [0.3, 0.2], [0.5, 0.2], [0.7, 0.2], [0.1, 0.5], [0.4, 0.5]];

/// What effects say that need to know what moves the site.
const NO_EQUATION: Reason = Reason::Missing("equation of motion");

/// The laws of an effect at every site whose velocity moves in the replay.
fn each_site<'a>(
    effect: &'a dyn Effect,
    nominal: &'a Model,
    scales: &'a ReplayScales,
    laws: impl Fn(&dyn Fn(&'static str) -> Sketch<'a>, &SiteUnits<'a>) -> Vec<Sketch<'a>>,
) -> Offers {
    let offers = scales.sites.iter().enumerate().flat_map(|(i, site)| {
        let sketch = |law| {
            Sketch::of_force(effect, law, nominal, scales, i)
                .require(site.force > 0.0, Reason::Still("what the force would move"))
        };
        laws(&sketch, &SiteUnits { index: i, site, nominal })
    });
    offers.map(Sketch::finish).collect()
}

/// Units of force, velocity and displacement at a site, for scales and texts.
struct SiteUnits<'a> {
    index: usize,
    site: &'a ForceScale,
    nominal: &'a Model,
}

impl SiteUnits<'_> {
    /// Force of which effects are fractions.
    fn force(&self) -> f64 {
        self.site.force
    }

    /// Standard deviation of the velocity; NaN without one, which makes what depends on it not
    /// testable.
    fn velocity(&self) -> f64 {
        moving(self.site.velocity.as_ref()).map_or(f64::NAN, |signal| signal.std)
    }

    /// Root mean square of the position; of the travel of a swing with the acceleration of the
    /// replay where the site has a velocity only.
    fn position(&self) -> f64 {
        match &self.site.position {
            Some(_) => moving(self.site.position.as_ref()).map_or(f64::NAN, SignalScale::rms),
            None => self.velocity() * self.velocity() / self.site.motion.std,
        }
    }

    /// Unit of the force per velocity to a power.
    fn per_velocity(&self, power: u8) -> String {
        self.per_signal(self.velocity_unit(), power)
    }

    /// Unit of the force per displacement to a power.
    fn per_position(&self, power: u8) -> String {
        self.per_signal(self.position_unit(), power)
    }

    fn per_signal(&self, unit: String, power: u8) -> String {
        let by = match (unit.as_str(), power) {
            ("1", _) | (_, 1) => unit,
            (unit, power) if unit.contains([' ', '/']) => format!("({unit})^{power}"),
            (unit, power) => format!("{unit}^{power}"),
        };
        per(&self.site.unit, &by)
    }

    fn velocity_unit(&self) -> String {
        unit_of(self.nominal, self.site.velocity.as_ref())
    }

    fn position_unit(&self) -> String {
        match (&self.site.position, self.velocity_unit().strip_suffix("/s")) {
            (None, Some(unit)) => unit.to_owned(),
            (position, _) => unit_of(self.nominal, position.as_ref()),
        }
    }

    /// Whether the file gives the site a velocity of its own.
    fn has_velocity(&self) -> bool {
        self.nominal.sites[self.index].velocity.is_some()
    }
}

impl Sketch<'_> {
    /// Gives up unless the site has a velocity that moves.
    fn with_velocity(self, units: &SiteUnits<'_>) -> Self {
        self.require(units.site.velocity.is_some(), Reason::Missing("velocity"))
            .require(moving(units.site.velocity.as_ref()).is_some(), Reason::Still("the velocity"))
    }

    /// Gives up unless the site has a position that moves.
    fn with_position(self, units: &SiteUnits<'_>) -> Self {
        self.require(units.site.position.is_some(), Reason::Missing("position"))
            .require(moving(units.site.position.as_ref()).is_some(), Reason::Still("the position"))
    }
}

fn moving(signal: Option<&(fd_sim::equation::Expr, SignalScale)>) -> Option<&SignalScale> {
    signal.map(|(_, scale)| scale).filter(|scale| scale.moves())
}

/// The unit that all states and inputs in the expression have, `"1"` if there is none.
fn unit_of(model: &Model, signal: Option<&(fd_sim::equation::Expr, SignalScale)>) -> String {
    let Some((expr, _)) = signal else { return "1".to_owned() };
    let states = model.states.iter().map(|state| (&state.name, &state.unit));
    let inputs = model.inputs.iter().map(|input| (&input.name, &input.unit));
    let mut units = states.chain(inputs).filter(|(name, _)| expr.mentions(name));
    let first = units.next().map_or("1", |(_, unit)| unit);
    if units.all(|(_, unit)| unit == first) { first.to_owned() } else { "1".to_owned() }
}
