//! Suspects of which the user wants only some.

use fd_effect::{Candidate, EverySite, NotTestable, Offers, Suspects};
use fd_sim::model::Model;

use super::error::GapError;

/// Effects at every site, or only those that are named.
#[derive(Debug)]
pub(super) struct Chosen<'a> {
    every: EverySite<'a>,
    only: Vec<String>,
}

impl<'a> Chosen<'a> {
    /// Checks that all names mean something for the model.
    pub(super) fn new(
        every: EverySite<'a>,
        model: &Model,
        exclude: &[String],
        only: &[String],
    ) -> Result<Self, GapError> {
        let effects = every.effects();
        let mut kinds: Vec<String> =
            effects.iter().flat_map(|e| [e.label(), e.family()]).map(str::to_owned).collect();
        kinds.sort();
        kinds.dedup();
        let mut sites = sites(model);
        let is_asked = |name: &String| name.contains('@');
        if exclude.iter().chain(only).any(is_asked) {
            // Parts of a simulator outside are known to its own effects only.
            let offers = every.alone();
            let parts = offers.iter().flatten().filter_map(|candidate| candidate.site.name());
            sites.extend(
                parts.map(str::to_owned).filter(|part| !sites.contains(part)).collect::<Vec<_>>(),
            );
        }
        for (option, names) in [("--exclude", exclude), ("--only", only)] {
            for name in names {
                let (kind, site) = name.split_once('@').unwrap_or((name, ""));
                for (what, name, known) in [("effect", kind, &kinds), ("site", site, &sites)] {
                    let is_known = name.is_empty() && what == "site"
                        || known.iter().any(|known| known == name);
                    if !is_known {
                        let (name, known) = (name.to_owned(), known.clone());
                        return Err(GapError::Unknown { option, what, name, known });
                    }
                }
            }
        }
        Ok(Self { every: every.without(exclude), only: only.to_vec() })
    }

    fn filter(&self, mut offers: Offers) -> Offers {
        if self.only.is_empty() {
            return offers;
        }
        let effects = self.every.effects();
        let is_wanted = |label: &str, site: Option<&str>| {
            let family =
                effects.iter().find(|effect| effect.label() == label).map_or("", |e| e.family());
            self.only.iter().any(|only| {
                let (kind, place) = only.split_once('@').unwrap_or((only, ""));
                (kind == label || kind == family) && (place.is_empty() || site == Some(place))
            })
        };
        offers.retain(|offer| match offer {
            Ok(Candidate { label, site, .. }) | Err(NotTestable { label, site, .. }) => {
                is_wanted(label, site.name())
            }
        });
        offers
    }
}

impl Suspects for Chosen<'_> {
    fn alone(&self) -> Offers {
        self.filter(self.every.alone())
    }

    fn beside(&self, first: &Candidate) -> Offers {
        self.filter(self.every.beside(first))
    }
}

/// Names of all places of a model.
fn sites(model: &Model) -> Vec<String> {
    let inputs = model.inputs.iter().map(|input| &input.name);
    let forces = model.sites.iter().map(|site| &site.name);
    let states = model.states.iter().map(|state| &state.name);
    let outputs = model.outputs.iter().map(|output| &output.name);
    let parameters = model.parameters.iter().map(|parameter| &parameter.name);
    inputs.chain(forces).chain(states).chain(outputs).chain(parameters).cloned().collect()
}
