//! What could be told from a case without noise, by refits to its noise-free truth.

use fd_effect::{Candidate, Suspects};
use fd_gap::fit::FitError;
use fd_model::Record;
use fd_sim::model::{LoadError, Model};
use serde::{Deserialize, Serialize};

use super::{
    error::BlindError,
    refit::{Fitted, Sight, simulated},
    truth::{Scene, Truth},
};

/// Squares of the noise below which two explanations are one.
pub(super) const SEPARATED: f64 = 9.0;

/// Laws of one of two effects beside which the other is fitted.
const FIRSTS: usize = 2;
/// What refits to the noise-free truth leave, in squares of the noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Oracle {
    /// By the nominal model, with nuisances around the truth or around what the model file says,
    /// whatever is less: below 9 the case is invisible.
    pub nothing: f64,
    /// By single effects of the library that leave less than 9: they cannot be told from the truth.
    pub ties: Vec<Rival>,
    /// The least that any single effect of the library leaves.
    pub best: Option<Rival>,
}

/// An effect of the library with what it leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rival {
    /// Label.
    pub label: String,
    /// Name of its site.
    pub site: String,
    /// The other end of a coupling.
    pub partner: Option<String>,
    /// Mechanism.
    pub family: String,
    /// Law that leaves the least.
    pub law: String,
    /// What it leaves.
    pub distance: f64,
}

/// What the nominal model leaves at least of the noise-free truth.
///
/// The real parameters lie somewhere within their tolerance. The box of a diagnosis has the nominal
/// ones in its middle, so that it reaches further on one side than a box around the truth. What it
/// can reach there, nobody who knows no more than the model file can call an effect: there counts
/// what the effect adds to the least squares of the same run without it.
fn nothing(scene: &Scene<'_>, at_truth: f64, clean: &Record) -> Result<f64, BlindError> {
    let (truth, model) = (scene.truth, scene.model);
    let without = Truth { effects: Vec::new(), ..truth.clone() };
    let without = Scene::new(&without, model)?.log(0, false)?;
    let Some(without) = without else { return Ok(at_truth) };
    let cost = |log: &Record| -> Result<Option<f64>, BlindError> {
        Ok(Sight::new(scene, model, log)?.null()?.map(|null| null.minimum.cost))
    };
    let (Some(with), Some(without)) = (cost(clean)?, cost(&without)?) else { return Ok(at_truth) };
    Ok(at_truth.min((with - without).max(0.0)))
}

/// The model with real parameters and initial states for nominal ones: distances are measured from
/// where the truth is, as the tie test of the diagnosis does.
fn centred(scene: &Scene<'_>) -> Result<Model, BlindError> {
    let mut draft = scene.model.clone().into_draft();
    for (parameter, value) in draft.parameters.iter_mut().zip(&scene.truth.parameters) {
        parameter.tolerance *= (parameter.value / value).abs();
        parameter.value = *value;
    }
    for (state, value) in draft.states.iter_mut().zip(scene.initial(0)) {
        state.initial = value;
    }
    Model::try_from(draft).map_err(|error| {
        let file = "the model at the truth".to_owned();
        BlindError::Model { error: Box::new(LoadError::Model { file, error }) }
    })
}

/// What could be told from the noise-free log of a scene; with `rivals`, everything in the library
/// that explains it.
pub(super) fn oracle(scene: &Scene<'_>, log: &Record, rivals: bool) -> Result<Oracle, BlindError> {
    let model = centred(scene)?;
    let sight = Sight::new(scene, &model, log)?;
    let null = sight.null()?.ok_or(FitError::Diverged)?;
    let nothing = nothing(scene, null.minimum.cost, log)?;
    let mut oracle = Oracle { nothing, ..Oracle::default() };
    if nothing < SEPARATED || !rivals {
        return Ok(oracle);
    }
    let candidates = simulated(sight.suspects().alone());
    let mut rivals: Vec<Rival> = Vec::new();
    for Fitted { candidate, minimum, .. } in sight.fitted(candidates, &null) {
        let distance = minimum.cost;
        let rival = Rival { distance, ..Rival::of(&candidate) };
        match rivals.iter_mut().find(|known| known.is_same(&rival)) {
            Some(known) if distance < known.distance => *known = rival,
            Some(_) => {}
            None => rivals.push(rival),
        }
    }
    rivals.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    oracle.best = rivals.first().cloned();
    rivals.retain(|rival| rival.distance < SEPARATED);
    oracle.ties = rivals;
    Ok(oracle)
}

/// The least that named effects leave, one or two, over all their laws and starts.
pub(super) fn distance_of(
    scene: &Scene<'_>,
    log: &Record,
    wanted: &[&dyn Fn(&Candidate) -> bool],
) -> Result<f64, BlindError> {
    let model = centred(scene)?;
    let sight = Sight::new(scene, &model, log)?;
    let Some(null) = sight.null()? else { return Ok(f64::INFINITY) };
    let suspects = sight.suspects();
    let mut least = null.minimum.cost;
    for (i, first) in wanted.iter().enumerate() {
        let alone = simulated(suspects.alone()).filter(|candidate| first(candidate));
        for fit in sight.fitted(alone, &null).into_iter().take(FIRSTS) {
            least = least.min(fit.minimum.cost);
            for (_, second) in wanted.iter().enumerate().filter(|(j, _)| *j != i) {
                let beside = simulated(suspects.beside(&fit.candidate)).filter(|c| second(c));
                let both = sight.fitted(beside, &fit.granted()?);
                least = both.first().map_or(least, |both| least.min(both.minimum.cost));
            }
        }
    }
    Ok(least)
}

impl Rival {
    fn of(candidate: &Candidate) -> Self {
        Self {
            label: candidate.label.to_owned(),
            site: candidate.site.name().unwrap_or_default().to_owned(),
            partner: candidate.partner.as_ref().and_then(|p| p.name()).map(str::to_owned),
            family: candidate.family.to_owned(),
            law: candidate.law.to_owned(),
            distance: f64::INFINITY,
        }
    }

    fn is_same(&self, other: &Self) -> bool {
        self.label == other.label && self.site == other.site && self.partner == other.partner
    }
}
