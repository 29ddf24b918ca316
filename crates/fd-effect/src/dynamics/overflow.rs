//! A store that overflows.

use fd_sim::{
    equation::Expr,
    model::{Law, Model},
    scales::ReplayScales,
};

use crate::{Effect, Offers, Reason, SiteRef, Sketch, units::per};

/// Heights of the brim from which to start, as fractions of the range of the nominal model; the real
/// one may rise higher.
const LEVELS: [f64; 7] = [0.62, 0.8, 0.42, 0.92, 0.96, 1.0, 1.04];

/// A level that cannot rise above `low + 1/s`, where `low` is the lowest level of the nominal
/// model: what flows in beyond is lost, or a share `h` of it reaches a neighbour. The strength is
/// the inverse of the height, so that none is exactly none.
///
/// Only for sites whose position is the very state that the force enters, or that name neither position nor velocity: a
/// tank, a temperature, a pressure. The rise is stopped within `Z`, a hundredth of the range, or what the
/// level can rise in two integration steps.
#[derive(Clone, Copy, Debug)]
pub struct Overflow;

impl Effect for Overflow {
    fn label(&self) -> &'static str {
        "overflow"
    }

    fn family(&self) -> &'static str {
        "limit"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let mut offers = Vec::new();
        for (i, site) in scales.sites.iter().enumerate() {
            let sketch =
                |law| spills(Sketch::of_force(self, law, nominal, scales, i), nominal, scales, i);
            offers.push(sketch("lost").starts(LEVELS.map(|level| [1.0 / level])).finish());
            let is_neighbour = |j: usize| {
                i != j && scales.sites[j].unit == site.unit && store(nominal, j).is_some()
            };
            for j in (0..scales.sites.len()).filter(|j| is_neighbour(*j)) {
                let neighbour = &scales.sites[j].name;
                let sketch = sketch("shared")
                    .partner(SiteRef::Force(j, neighbour.clone()))
                    .shape("h", "overflow_share", "1", 1.0, [0.0, 1.0], 0.0)
                    .force_at(neighbour, "caught", "h*e")
                    .starts(LEVELS.map(|level| [1.0 / level, 0.7]));
                offers.push(sketch.finish());
            }
        }
        offers
    }
}

/// A force that takes away what rises beyond the brim, and `e`, how much that is.
fn spills<'a>(sketch: Sketch<'a>, nominal: &Model, scales: &ReplayScales, i: usize) -> Sketch<'a> {
    let site = &scales.sites[i];
    let Some(store) = store(nominal, i) else {
        return sketch.require(false, Reason::Missing("level"));
    };
    let (low, high) = site.level().map_or((0.0, 0.0), |(_, s)| (s.low, s.high));
    let range = high - low;
    let zone = (0.01 * range).max(2.0 * scales.step * site.motion.peak());
    sketch
        .require(range > 0.0 && site.force > 0.0, Reason::Still("the level"))
        .limit("s", "brim", per("1", store.unit), 1.0 / range, [0.0, 12.5])
        .bind("x", Expr::name(store.state))
        .bind("S", 1e-9 / range)
        .bind("l", low)
        .bind("Z", zone)
        .bind("R", store.rate)
        .with_helpers(&site.helpers)
        .bind("C", site.compliance.clone())
        .said("s", [None, Some("l + 1/s")])
        .define("e", "overflow", "clamp((x - l - 1/max(s, S))/Z, 0, 1)*max(R, 0)/C")
        .force("spilled", "-e")
}

/// A state that a force fills.
struct Store<'a> {
    state: &'a str,
    unit: &'a str,
    rate: Expr,
}

fn store(model: &Model, site: usize) -> Option<Store<'_>> {
    let site = &model.sites[site];
    let [(entered, _)] = site.enters.as_slice() else { return None };
    let is_itself = |position: &Expr| *position == Expr::name(entered);
    let is_level = site.position.as_ref().map_or(site.velocity.is_none(), is_itself);
    let state = model.states.iter().find(|state| is_level && state.name == *entered)?;
    // A velocity is nothing that fills.
    let is_rate = site.position.is_none() && state.unit.ends_with("/s");
    match &state.law {
        Law::Derivative(rate) if !is_rate => {
            Some(Store { state: &state.name, unit: &state.unit, rate: rate.clone() })
        }
        Law::Derivative(_) | Law::Update(_) => None,
    }
}
