//! What a diagnosis tries: candidates alone, and beside one that is already known.

use std::fmt::Debug;

use fd_sim::model::Model;
use fd_sim::scales::ReplayScales;

use super::{Candidate, Effect, NotTestable, Offers, offers};

/// What a diagnosis tries.
///
/// [`EverySite`] is the usual one. A list of candidates is another: exactly these, and no pairs.
///
/// ```
/// use fd_effect::{Candidate, EverySite, Suspects, library};
/// use fd_sim::{model::Model, scales::ReplayScales};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "tank"
/// sample_time = 60.0
/// inputs = { flow = { unit = "m^3/s" } }
/// states = { h = { unit = "m", initial = 1.0, derivative = "flow - 1e-4*h" } }
/// outputs = { level = { unit = "m", value = "h" } }
/// "#.parse()?;
/// let u: Vec<f64> = (0..500).map(|k| if k % 100 < 50 { 1e-4 } else { 2e-4 }).collect();
/// let scales = ReplayScales::of(&model, model.sample_time()?, &u, 500)?;
///
/// let every = EverySite::new(library(), &model, scales);
/// let only_sensors: Vec<Candidate> =
///     every.alone().into_iter().flatten().filter(|c| c.site.name() == Some("level")).collect();
/// assert!(!only_sensors.is_empty() && only_sensors.len() < every.alone().len());
/// assert_eq!(only_sensors.alone().len(), only_sensors.len());
/// assert!(only_sensors.beside(&only_sensors[0]).is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Suspects: Debug + Send + Sync {
    /// Candidates on the nominal model, or the reason why there is none.
    fn alone(&self) -> Offers;

    /// Candidates on a model that has the effect of `first` in it. They have its parameters as
    /// well as their own, which come last.
    fn beside(&self, first: &Candidate) -> Offers;
}

/// Candidates that are there already, and nothing beside them.
impl Suspects for [Candidate] {
    fn alone(&self) -> Offers {
        self.iter().cloned().map(Ok).collect()
    }

    fn beside(&self, _first: &Candidate) -> Offers {
        Vec::new()
    }
}

impl Suspects for Vec<Candidate> {
    fn alone(&self) -> Offers {
        self.as_slice().alone()
    }

    fn beside(&self, first: &Candidate) -> Offers {
        self.as_slice().beside(first)
    }
}

/// Effects at every site of a model, except those that its user excludes.
#[derive(Debug)]
pub struct EverySite<'a> {
    effects: Vec<Box<dyn Effect>>,
    model: &'a Model,
    scales: ReplayScales,
    excluded: Vec<String>,
    has_alike: bool,
}

impl<'a> EverySite<'a> {
    /// Effects at every site of a model.
    ///
    /// ```
    /// use fd_effect::{EverySite, Suspects, library};
    /// use fd_sim::{scales::ReplayScales, model::Model};
    ///
    /// let model: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "tank"
    /// sample_time = 60.0
    /// inputs = { flow = { unit = "m^3/s" } }
    /// states = { h = { unit = "m", initial = 1.0, derivative = "flow - 1e-4*h" } }
    /// outputs = { level = { unit = "m", value = "h" } }
    /// "#.parse()?;
    /// let u: Vec<f64> = (0..500).map(|k| if k % 100 < 50 { 1e-4 } else { 2e-4 }).collect();
    /// let scales = ReplayScales::of(&model, model.sample_time()?, &u, 500)?;
    /// let suspects = EverySite::new(library(), &model, scales).without(&["input-delay@flow".to_owned()]);
    /// let all = suspects.alone();
    /// assert!(all.iter().flatten().all(|c| (c.label, c.site.name()) != ("input-delay", Some("flow"))));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new(effects: Vec<Box<dyn Effect>>, model: &'a Model, scales: ReplayScales) -> Self {
        Self { effects, model, scales, excluded: Vec::new(), has_alike: true }
    }

    /// Leaves out labels (`coulomb-friction`), families (`friction`), or either at one site
    /// (`input-delay@u`).
    #[must_use]
    pub fn without(mut self, excluded: &[String]) -> Self {
        self.excluded.extend_from_slice(excluded);
        self
    }

    /// Each place for itself, none [alike](crate::SiteRef::Alike).
    #[must_use]
    pub fn one_by_one(mut self) -> Self {
        self.has_alike = false;
        self
    }

    /// Sizes of the signals that candidates are scaled with.
    #[must_use]
    pub fn scales(&self) -> &ReplayScales {
        &self.scales
    }

    /// The effects that are tried.
    #[must_use]
    pub fn effects(&self) -> &[Box<dyn Effect>] {
        &self.effects
    }

    fn on(&self, model: &Model) -> Offers {
        let (effects, scales) = (&self.effects, &self.scales);
        let mut offers = if self.has_alike {
            offers(effects, model, scales)
        } else {
            effects.iter().flat_map(|effect| effect.candidates(model, scales)).collect()
        };
        offers.retain(|offer| {
            let (label, family, site) = match offer {
                Ok(Candidate { label, family, site, .. }) => (label, *family, site),
                Err(NotTestable { label, site, .. }) => (label, "", site),
            };
            !self.excluded.iter().any(|excluded| {
                let (what, place) = excluded.split_once('@').unwrap_or((excluded, ""));
                (what == *label || what == family)
                    && (place.is_empty() || site.each().iter().any(|s| s.name() == Some(place)))
            })
        });
        offers
    }
}

impl Suspects for EverySite<'_> {
    fn alone(&self) -> Offers {
        self.on(self.model)
    }

    fn beside(&self, first: &Candidate) -> Offers {
        self.on(&first.model)
    }
}
