//! One law at several places that are made alike, with one strength for all of them.
//!
//! Commands of a robot come over one bus, and all of them late; all its encoders pass one filter; a vehicle is dragged the
//! same way in every direction. At one place alone such a law explains little, beside what the others leave: it is seen at all
//! of them together.
//!
//! *When not to use:* where places differ. Then each has its own strength, and a set of laws is the answer.

use std::collections::BTreeMap;

use fd_sim::{
    model::{Model, Parameter},
    scales::ReplayScales,
};

use super::{Candidate, Effect, EffectParameter, Kind, NotTestable, SiteRef};

/// The simplest law of an effect at all places of a kind together, for each kind of which there are several. `offered` is what
/// the effect offers for the model at each of them.
pub(super) fn alike(
    effect: &dyn Effect,
    offered: &[Result<Candidate, NotTestable>],
    nominal: &Model,
    scales: &ReplayScales,
) -> Vec<Candidate> {
    let mut offered = offered.iter().flatten().filter(|_| effect.is_often_alike()).peekable();
    let Some(law) = offered.peek().map(|first| first.law) else { return Vec::new() };
    let mut kinds: BTreeMap<(&str, &str), Vec<&Candidate>> = BTreeMap::new();
    for candidate in offered.filter(|candidate| candidate.law == law) {
        let kind = match candidate.site {
            SiteRef::Input(..) => "input",
            SiteRef::Force(..) => "force",
            SiteRef::Output(..) => "output",
            _ => continue,
        };
        let unit = candidate.parameters.first().map_or("", |p| p.unit.as_str());
        kinds.entry((kind, unit)).or_default().push(candidate);
    }
    let several = kinds.into_values().filter(|places| 1 < places.len());
    several.filter_map(|places| together(effect, &places, nominal, scales)).collect()
}

/// A law at all of these places; `None` where what it does at one forbids it at another.
fn together(
    effect: &dyn Effect,
    places: &[&Candidate],
    nominal: &Model,
    scales: &ReplayScales,
) -> Option<Candidate> {
    let (first, others) = places.split_first()?;
    if first.kind != Kind::Simulation || first.rounding.is_some() || first.spectral.is_some() {
        return None;
    }
    let sites: Vec<SiteRef> = places.iter().map(|candidate| candidate.site.clone()).collect();
    let mut all = Candidate { site: SiteRef::alike(sites), ..(*first).clone() };
    name_for_all(&mut all, &first.site.prefix())?;
    for place in others {
        let on_top = effect.candidates(&all.model, scales).into_iter().flatten();
        let next = on_top.into_iter().find(|c| c.law == place.law && c.site == place.site)?;
        merge(&mut all, next)?;
    }
    let is_added = |p: &Parameter| nominal.parameter(&p.name).is_none();
    (all.model.parameters.iter().filter(|p| is_added(p)).count() == all.parameters.len())
        .then_some(all)
}

/// Gives the parameters of the first place names that do not speak of it.
fn name_for_all(all: &mut Candidate, prefix: &str) -> Option<()> {
    let (mut draft, alike) = (all.model.clone().into_draft(), all.site.prefix());
    for parameter in &mut all.parameters {
        let what = parameter.name.strip_prefix(&format!("{prefix}_")).unwrap_or(&parameter.name);
        let name = draft.fresh_name(&format!("{alike}_{what}"));
        draft.rename(&parameter.name, &name);
        parameter.name = name;
    }
    all.model = Model::try_from(draft).ok()?;
    Some(())
}

/// Takes up the law at one more place, which is on top of those before, with their parameters in place of its own.
fn merge(all: &mut Candidate, next: Candidate) -> Option<()> {
    let mut draft = next.model.into_draft();
    for (known, own) in all.parameters.iter_mut().zip(&next.parameters) {
        draft.parameters.retain(|parameter| parameter.name != own.name);
        for expr in draft.expressions_mut() {
            *expr = expr.rename(&own.name, &known.name);
        }
        let of_all = draft.parameters.iter_mut().find(|parameter| parameter.name == known.name)?;
        widen(known, own);
        of_all.bounds = Some([known.low, known.high]);
    }
    // What is little at one place may hold another one still.
    for (known, own) in all.starts.iter_mut().zip(&next.starts) {
        for (known, own) in known.iter_mut().zip(own) {
            *known = if own.abs() < known.abs() { *own } else { *known };
        }
    }
    all.model = Model::try_from(draft).ok()?;
    Some(())
}

/// What is usual at one place need not be so at another; what matters at one of them matters.
fn widen(known: &mut EffectParameter, own: &EffectParameter) {
    known.low = known.low.min(own.low);
    known.high = known.high.max(own.high);
    known.scale = known.scale.min(own.scale);
}
