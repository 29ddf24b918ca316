//! The library of effects that a simulator may lack, tried at every site of a model.
//!
//! An [`Effect`] offers [`Candidate`]s: patched models with parameters, their units, bounds and starts. Every
//! candidate is exactly the nominal model at zero strength, whatever its shape parameters are, on the
//! integration grid of the nominal model; bounds enforce the physical signs of strengths. Effects with memory
//! (play, lags, rate limits, hysteresis) are exact over an integration step for held inputs, and the plant
//! receives their mean over the step.
//!
//! Units, bounds and starts come from [`ReplayScales`], the sizes of all signals in a simulation
//! of the nominal model with the inputs of the log.
//!
//! ```
//! use fd_effect::{library, offers};
//! use fd_sim::{model::Model, scales::ReplayScales};
//!
//! let cart: Model = r#"
//! version = 1
//! kind = "equations"
//! name = "cart"
//! sample_time = 0.05
//! inputs = { u = { unit = "N" } }
//! outputs = { speed = { unit = "m/s", value = "v" } }
//! sites = { rail = { unit = "N", enters = { v = "0.5" }, velocity = "v" } }
//! [states]
//! v = { unit = "m/s", initial = 0.0, derivative = "0.5*u - 0.2*v" }
//! "#.parse()?;
//! let u: Vec<f64> = (0..400).map(|k| (0.1 * f64::from(k)).sin()).collect();
//! let scales = ReplayScales::of(&cart, cart.sample_time()?, &u, 400)?;
//!
//! // What may be missing in it, and what cannot be tested with this model, with the reason.
//! let offers = offers(&library(), &cart, &scales);
//! let coulomb = offers.iter().flatten().find(|candidate| candidate.label == "coulomb-friction");
//! assert!(coulomb.is_some_and(|candidate| candidate.site.name() == Some("rail")));
//! let refused: Vec<String> =
//!     offers.iter().filter_map(|offer| offer.as_ref().err()).map(ToString::to_string).collect();
//! assert!(refused.iter().any(|why| why.contains("the site has no position")), "{refused:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod alike;
mod candidate;
mod default_sites;
pub mod dynamics;
mod inner_places;
pub mod input;
mod label;
pub mod map;
mod native;
pub mod sensor;
mod site;
mod sketch;
mod suspects;
pub mod text;
mod units;

use fd_sim::{model::Model, scales::ReplayScales};

use self::alike::alike;
pub use self::{
    candidate::{
        Candidate, Effect, EffectParameter, InAnotherRun, Kind, NotTestable, Observation, Offers,
        Reason, Rounding,
    },
    default_sites::with_default_sites,
    inner_places::with_inner_places,
    label::interned,
    native::{NATIVE, natives},
    site::{Side, SiteRef},
    sketch::Sketch,
    suspects::{EverySite, Suspects},
};

/// All effects that are known: the lists of the four sides, one after the other.
///
/// ```
/// use fd_effect::library;
///
/// let labels: Vec<&str> = library().iter().map(|effect| effect.label()).collect();
/// assert!(labels.contains(&"coulomb-friction"));
/// ```
#[must_use]
pub fn library() -> Vec<Box<dyn Effect>> {
    [input::all(), dynamics::all(), sensor::all(), map::all()].into_iter().flatten().collect()
}

/// What all effects of a library offer for a model, in the order of the library: at each place, and at all places of a kind
/// together where these are often made alike.
#[must_use]
pub fn offers(library: &[Box<dyn Effect>], nominal: &Model, scales: &ReplayScales) -> Offers {
    let each = library.iter().flat_map(|effect| {
        let mut offers = effect.candidates(nominal, scales);
        let alike = alike(&**effect, &offers, nominal, scales);
        offers.extend(alike.into_iter().map(Ok));
        offers
    });
    each.collect()
}
