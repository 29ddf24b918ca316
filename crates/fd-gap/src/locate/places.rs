//! Sides of the plant, and places on them: inputs, forces, state equations, outputs.

use crate::together::each;
use fd_effect::{Side, SiteRef};
use fd_sim::{equation::Expr, model::Model, simulate::Simulator};

use super::{
    free_signal::Probe,
    result::{FreeSignal, PlaceEvidence, SideEvidence},
};
use crate::diagnose::{Cause, Diagnosis, Monitor, SideShare, Stage};

/// Probability from which a place is named.
const NAMED: f64 = 0.5;
/// Probability below which nothing is said of it.
const NEGLIGIBLE: f64 = 0.005;
/// Evidence from which a free signal counts, in nats.
pub(super) const EVIDENT: f64 = 3.0;

pub(super) fn places(
    model: &Model,
    diagnosis: &Diagnosis,
    probe: &Probe<'_>,
    monitor: &dyn Monitor,
) -> Vec<PlaceEvidence> {
    let sites = sites(model, probe.simulator(), diagnosis);
    monitor.begin(Stage::Locate, sites.len());
    let weights = weights(model, diagnosis, &sites);
    let mut places = each(sites.into_iter().zip(weights), |((site, equations), probability)| {
        let free = probe.at(&site);
        let side = side(&site);
        let statement = words(&site, probability, free.as_ref(), model.outputs.len());
        monitor.advance();
        PlaceEvidence { site, side, equations, probability, free, statement }
    });
    let evidence = |place: &PlaceEvidence| place.free.as_ref().map_or(0.0, |f| f.log_evidence);
    // What differs by rounding is equal.
    let key = |place: &PlaceEvidence| (1e6 * place.probability).round();
    let evidence = |place: &PlaceEvidence| (10.0 * evidence(place)).round();
    places.sort_by(|a, b| key(b).total_cmp(&key(a)).then(evidence(b).total_cmp(&evidence(a))));
    places
}

pub(super) fn sides(diagnosis: &Diagnosis, places: &[PlaceEvidence]) -> Vec<SideEvidence> {
    let outputs = diagnosis.sigma.len();
    let side = |&SideShare { side, probability }: &SideShare| {
        let probability = probability.max(0.0);
        let here = places.iter().filter(|place| place.side == side);
        let shares = here.filter_map(|place| place.free.as_ref()).map(|free| free.share);
        let free_share = shares.reduce(f64::max);
        let name = match side {
            Side::Input => "before the plant (actuator)",
            Side::Dynamics => "in the plant (dynamics)",
            Side::Output => "behind the plant (sensor)",
        };
        // With one output a free signal explains it from nearly anywhere, which says nothing.
        let free = free_share.filter(|_| 1 < outputs).map_or_else(String::new, |share| {
            format!("; a free signal there explains up to {:.0} % of the gap", 100.0 * share)
        });
        let statement = format!("{name}: probability {probability:.2}{free}");
        SideEvidence { side, probability, free_share, statement }
    };
    diagnosis.sides.iter().map(side).collect()
}

fn side(site: &SiteRef) -> Side {
    match site {
        SiteRef::Alike(places, _) => places.first().map_or(Side::Dynamics, side),
        SiteRef::Input(..) => Side::Input,
        SiteRef::Output(..) => Side::Output,
        _ => Side::Dynamics,
    }
}

/// All places with the states whose equations they enter; a state that one force alone enters is not
/// listed again. A shell around a black box has inputs and states that are none of the plant; and
/// parameters on which no equation depends, or several outputs, are places where there is a cause.
fn sites(
    model: &Model,
    simulator: &dyn Simulator,
    diagnosis: &Diagnosis,
) -> Vec<(SiteRef, Vec<String>)> {
    let mut all = Vec::new();
    let open = match model.controller {
        Some(_) => model.inputs.len(),
        None => simulator.inputs().len(),
    };
    for (i, input) in model.inputs.iter().enumerate().take(open) {
        all.push((SiteRef::Input(i, input.name.clone()), Vec::new()));
    }
    for (i, site) in model.sites.iter().enumerate() {
        let entered = site.enters.iter().map(|(state, _)| state.clone()).collect();
        all.push((SiteRef::Force(i, site.name.clone()), entered));
    }
    for (i, state) in model.states.iter().enumerate() {
        let is_real = simulator.initial().iter().any(|known| known.channel.name == state.name);
        if is_real && force_on(model, &state.name).is_none() {
            all.push((SiteRef::State(i, state.name.clone()), vec![state.name.clone()]));
        }
    }
    for (i, output) in model.outputs.iter().enumerate() {
        all.push((SiteRef::Output(i, output.name.clone()), Vec::new()));
    }
    for cause in &diagnosis.causes {
        let is_hidden =
            matches!(cause.site, SiteRef::Parameter(..) | SiteRef::Signal(..) | SiteRef::Part(..))
                && places_of(model, cause, &all).is_empty()
                && !all.iter().any(|(site, _)| *site == cause.site);
        if is_hidden {
            all.push((cause.site.clone(), Vec::new()));
        }
    }
    all
}

/// The force site that enters this equation and no other.
fn force_on(model: &Model, state: &str) -> Option<usize> {
    model.sites.iter().position(|site| match site.enters.as_slice() {
        [(entered, _)] => entered == state,
        _ => false,
    })
}

/// Probability of each site.
fn weights(model: &Model, diagnosis: &Diagnosis, sites: &[(SiteRef, Vec<String>)]) -> Vec<f64> {
    let mut weights = vec![0.0; sites.len()];
    for cause in &diagnosis.causes {
        let places = places_of(model, cause, sites);
        for place in &places {
            weights[*place] += cause.probability / places.len() as f64;
        }
    }
    weights
}

/// Sites that a cause acts at.
fn places_of(model: &Model, cause: &Cause, sites: &[(SiteRef, Vec<String>)]) -> Vec<usize> {
    let place = |wanted: &SiteRef| sites.iter().position(|(site, _)| site == wanted);
    let of_state = |name: &str| {
        let state = model.states.iter().position(|state| state.name == name)?;
        match force_on(model, name) {
            Some(force) => place(&SiteRef::Force(force, model.sites[force].name.clone())),
            None => place(&SiteRef::State(state, name.to_owned())),
        }
    };
    match &cause.site {
        SiteRef::State(_, name) => of_state(name).into_iter().collect(),
        // What carries it is where it shows, as of a parameter.
        SiteRef::Signal(_, name) | SiteRef::Parameter(_, name) => {
            let states = model.states.iter();
            let touched = states.filter(|state| depends(model, state.law.expr(), name));
            let mut places: Vec<usize> = touched.filter_map(|s| of_state(&s.name)).collect();
            let touches_outputs = places.is_empty();
            if touches_outputs {
                let outputs = model.outputs.iter().enumerate();
                let touched = outputs.filter(|(_, output)| depends(model, &output.value, name));
                places = touched
                    .filter_map(|(i, output)| place(&SiteRef::Output(i, output.name.clone())))
                    .collect();
            }
            // Several outputs at once, or none: no place but its own.
            if touches_outputs && 1 < places.len() || places.is_empty() {
                places = place(&cause.site).into_iter().collect();
            }
            places.dedup();
            places
        }
        site => site.each().iter().filter_map(place).collect(),
    }
}

/// Whether an expression depends on a name, directly or through definitions.
fn depends(model: &Model, expr: &Expr, name: &str) -> bool {
    expr.mentions(name)
        || model.definitions.iter().any(|definition| {
            expr.mentions(&definition.name)
                && definition.name != name
                && depends(model, &definition.value, name)
        })
}

/// A site in words.
pub(crate) fn name(site: &SiteRef) -> String {
    match site {
        SiteRef::Input(_, name) => format!("input `{name}`"),
        SiteRef::Force(_, name) => format!("force site `{name}`"),
        SiteRef::State(_, name) => format!("the equation of `{name}`"),
        SiteRef::Output(_, name) => format!("output `{name}`"),
        SiteRef::Signal(_, name) => format!("signal `{name}`"),
        SiteRef::Parameter(_, name) => format!("parameter `{name}`"),
        SiteRef::Part(_, name) => format!("part `{name}`"),
        SiteRef::Alike(places, _) => places.iter().map(name).collect::<Vec<_>>().join(" and "),
        SiteRef::WholeModel => "the whole model".to_owned(),
    }
}

fn words(site: &SiteRef, probability: f64, free: Option<&FreeSignal>, outputs: usize) -> String {
    let name = name(site);
    let said = if probability < NEGLIGIBLE {
        format!("{name}: none of the causes tried is here")
    } else if NAMED < probability {
        format!("{name}: the cause is here with probability {probability:.2}")
    } else {
        format!("{name}: the cause may be here, with probability {probability:.2}")
    };
    match free {
        Some(free) if EVIDENT < free.log_evidence => {
            // One output can be brought to anything from anywhere.
            let but =
                if outputs == 1 { ", as it could nearly anywhere with one output" } else { "" };
            format!(
                "{said}; a free signal of {} {} here would explain {:.0} % of the gap{but}",
                super::channels::Short(free.rms),
                free.unit,
                100.0 * free.share
            )
        }
        Some(_) => format!("{said}; a free signal here would explain nothing significant"),
        None => format!("{said}; a free signal cannot be added here, or shows in no output"),
    }
}
