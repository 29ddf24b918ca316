//! The laws of an effect at every site, and the units there.

use fd_sim::{
    model::Model,
    scales::{ForceScale, ReplayScales, SignalScale},
};

use crate::{Effect, Offers, Reason, Sketch, units::per};

/// Beginning and length, as parts of the log, of what is there between two times, from which to start.
pub(crate) const BETWEEN: [[f64; 2]; 6] =
    [[0.1, 0.2], [0.3, 0.2], [0.5, 0.2], [0.7, 0.2], [0.1, 0.5], [0.4, 0.5]];

/// What effects say that need to know what moves the site.
pub(super) const NO_EQUATION: Reason = Reason::Missing("equation of motion");

/// The laws of an effect at every site whose velocity moves in the replay.
pub(super) fn each_site<'a>(
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
pub(super) struct SiteUnits<'a> {
    pub index: usize,
    pub site: &'a ForceScale,
    pub nominal: &'a Model,
}

impl SiteUnits<'_> {
    /// Force of which effects are fractions.
    pub(super) fn force(&self) -> f64 {
        self.site.force
    }

    /// Standard deviation of the velocity; NaN without one, which makes what depends on it not
    /// testable.
    pub(super) fn velocity(&self) -> f64 {
        moving(self.site.velocity.as_ref()).map_or(f64::NAN, |signal| signal.std)
    }

    /// Root mean square of the position; of the travel of a swing with the acceleration of the
    /// replay where the site has a velocity only.
    pub(super) fn position(&self) -> f64 {
        match &self.site.position {
            Some(_) => moving(self.site.position.as_ref()).map_or(f64::NAN, SignalScale::rms),
            None => self.velocity() * self.velocity() / self.site.motion.std,
        }
    }

    /// Unit of the force per velocity to a power.
    pub(super) fn per_velocity(&self, power: u8) -> String {
        self.per_signal(self.velocity_unit(), power)
    }

    /// Unit of the force per displacement to a power.
    pub(super) fn per_position(&self, power: u8) -> String {
        self.per_signal(self.position_unit(), power)
    }

    pub(super) fn per_signal(&self, unit: String, power: u8) -> String {
        let by = match (unit.as_str(), power) {
            ("1", _) | (_, 1) => unit,
            (unit, power) if unit.contains([' ', '/']) => format!("({unit})^{power}"),
            (unit, power) => format!("{unit}^{power}"),
        };
        per(&self.site.unit, &by)
    }

    pub(super) fn velocity_unit(&self) -> String {
        unit_of(self.nominal, self.site.velocity.as_ref())
    }

    pub(super) fn position_unit(&self) -> String {
        match (&self.site.position, self.velocity_unit().strip_suffix("/s")) {
            (None, Some(unit)) => unit.to_owned(),
            (position, _) => unit_of(self.nominal, position.as_ref()),
        }
    }

    /// Whether the file gives the site a velocity of its own.
    pub(super) fn has_velocity(&self) -> bool {
        self.nominal.sites[self.index].velocity.is_some()
    }
}

impl Sketch<'_> {
    /// Gives up unless the site has a velocity that moves.
    pub(super) fn with_velocity(self, units: &SiteUnits<'_>) -> Self {
        self.require(units.site.velocity.is_some(), Reason::Missing("velocity"))
            .require(moving(units.site.velocity.as_ref()).is_some(), Reason::Still("the velocity"))
    }

    /// Gives up unless the site has a position that moves.
    pub(super) fn with_position(self, units: &SiteUnits<'_>) -> Self {
        self.require(units.site.position.is_some(), Reason::Missing("position"))
            .require(moving(units.site.position.as_ref()).is_some(), Reason::Still("the position"))
    }
}

pub(super) fn moving(
    signal: Option<&(fd_sim::equation::Expr, SignalScale)>,
) -> Option<&SignalScale> {
    signal.map(|(_, scale)| scale).filter(|scale| scale.moves())
}

/// The unit that all states and inputs in the expression have, `"1"` if there is none.
pub(super) fn unit_of(
    model: &Model,
    signal: Option<&(fd_sim::equation::Expr, SignalScale)>,
) -> String {
    let Some((expr, _)) = signal else { return "1".to_owned() };
    let states = model.states.iter().map(|state| (&state.name, &state.unit));
    let inputs = model.inputs.iter().map(|input| (&input.name, &input.unit));
    let mut units = states.chain(inputs).filter(|(name, _)| expr.mentions(name));
    let first = units.next().map_or("1", |(_, unit)| unit);
    if units.all(|(_, unit)| unit == first) { first.to_owned() } else { "1".to_owned() }
}
