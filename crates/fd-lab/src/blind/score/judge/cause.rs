//! A named cause next to what is true: whether it is the effect, and what it leaves of the log.

use fd_effect::Candidate;

use super::said::said_of;
use crate::blind::{
    answer::Named,
    error::BlindError,
    files::Case,
    oracle::distance_of,
    truth::{Effect, Scene, Truth},
};

pub(super) fn is_exact(effect: &Effect, label: &str, site: &str, partner: Option<&str>) -> bool {
    let is_partner = match (effect.partner.as_deref(), partner) {
        (Some(a), Some(b)) => a == b,
        _ => true,
    };
    said_of(effect) == label && effect.site == site && is_partner
}

/// Label, site and partner of a cause.
pub(super) type Sought<'a> = (&'a str, &'a str, Option<&'a str>);

pub(super) fn sought(named: &Named) -> Sought<'_> {
    (&named.label, &named.site, named.partner.as_deref())
}

/// What causes, in any of their laws, leave of the noise-free truth.
pub(super) fn left<'a>(
    case: &Case,
    truth: &Truth,
    causes: impl IntoIterator<Item = Sought<'a>>,
) -> Result<f64, BlindError> {
    let model = case.model()?;
    let scene = Scene::new(truth, &model)?;
    let wanted = causes.into_iter().map(|(label, site, partner)| {
        move |candidate: &Candidate| {
            candidate.label == label
                && candidate.site.name() == Some(site)
                && candidate.partner.as_ref().and_then(|p| p.name()) == partner
        }
    });
    let wanted: Vec<_> = wanted.collect();
    let wanted: Vec<&dyn Fn(&Candidate) -> bool> = wanted.iter().map(|w| w as _).collect();
    distance_of(&scene, &wanted)
}
