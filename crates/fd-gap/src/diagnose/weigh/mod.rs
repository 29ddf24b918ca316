//! From fitted candidates to evidence: single causes, the colour of the noise, pairs.

pub(super) mod answer;
pub(super) mod colour;
pub(super) mod explain;
mod from_pairs;
mod gaussian;
mod jitter;
mod known;
pub(super) mod lack_of_fit;
mod leftover;
pub(super) mod measurement;
mod outliers;
mod pairs;
pub(super) mod priors;
pub(super) mod rank;
pub(super) mod singles;
pub(super) mod slow;
mod stronger_noise;
pub(super) mod values;

use self::{
    answer::{Answer, Proposal, choose},
    colour::{COLOURED, colour_of, with_colour},
    from_pairs::fitted_from,
    lack_of_fit::LackOfFit,
    pairs::seek_pairs,
    singles::{Singles, weigh_singles},
    slow::with_slow,
};
use super::{context::Context, search::searched::Searched, sets::EffectSet, settings::Settings};
use crate::{
    evidence::grades::{STRONG, VERY_STRONG},
    fit::FitError,
    quality::AT_THE_NOISE,
};

/// Single causes and pairs with their evidence, and the answer that it prefers.
#[derive(Debug)]
pub(super) struct Weighed<'a> {
    pub singles: Singles<'a>,
    /// Pairs that were fitted, the best first.
    pub pairs: Vec<EffectSet>,
    /// The best of the refitted model, the first single cause and the first pair.
    pub best: Answer,
    pub lack_of_fit: LackOfFit,
}

impl<'a> Weighed<'a> {
    /// Chooses the best answer.
    pub(super) fn of(singles: Singles<'a>, pairs: Vec<EffectSet>, settings: &Settings) -> Self {
        // So much better than a single cause that two are worth their name.
        let pair = pairs.first().and_then(EffectSet::answer);
        let pair = pair.map(|answer| Proposal { answer, price: VERY_STRONG });
        let best = choose(&singles.refit, singles.proposal(settings).into_iter().chain(pair));
        let lack_of_fit = singles.lack_of_fit(&best);
        Self { singles, pairs, best, lack_of_fit }
    }

    /// Whether even the best answer is so far above the noise that likelihoods are no use. What follows a log as it
    /// pleases, and still not down to the noise, is no answer to that: the best law is.
    pub(super) fn is_far(&self) -> bool {
        let noise = &self.singles.searched.noise;
        let follows = match self.best.effects {
            1 => self.singles.does_first_follow_anything(),
            2 => self.pairs.first().is_some_and(EffectSet::follows_anything),
            _ => false,
        };
        let is_short_of_it = follows && AT_THE_NOISE < noise.reach(&self.best.errors);
        let law = is_short_of_it.then(|| self.singles.first_law()).flatten();
        noise.is_far(law.as_ref().map_or(&self.best.errors, |law| &law.errors))
    }
}

/// Weighs single causes, and pairs where one cause may not be all. Far above the noise its colour
/// cannot be told, and may be another effect: then pairs come first, and the colour is that of what
/// the best of them leaves.
pub(super) fn weigh<'a>(
    searched: Searched<'a>,
    context: &Context<'a>,
) -> Result<Weighed<'a>, FitError> {
    let (searched, left) = with_slow_noise(searched, context.settings.finalists)?;
    // Errors above it leave room for a second effect, which a colour of the noise would hide.
    if searched.noise.reach(&left) <= AT_THE_NOISE {
        colour_then_pairs(searched, &left, context)
    } else {
        pairs_then_colour(searched, left, context)
    }
}

/// Errors in sigma: outputs, segments, samples.
type Errors = Vec<Vec<Vec<f64>>>;

/// The search and what its best single fit leaves, once outputs with slow noise of unknown size have that noise: as long as it counts as a gap, it leads
/// the fits of all other outputs astray.
fn with_slow_noise(
    searched: Searched<'_>,
    finalists: usize,
) -> Result<(Searched<'_>, Errors), FitError> {
    let left = searched.best_errors()?;
    let searched = Searched { noise: with_slow(&searched, &left)?, ..searched };
    if !searched.noise.slow.contains(&true) || searched.noise.reach(&left) <= AT_THE_NOISE {
        return Ok((searched, left));
    }
    let Some(weights) = colour_of(&searched, &searched.noise, &left) else {
        return Ok((searched, left));
    };
    let searched = with_colour(searched, &weights, finalists)?;
    let left = searched.best_errors()?;
    Ok((Searched { noise: with_slow(&searched, &left)?, ..searched }, left))
}

/// The noise takes the colour of what the best single fit leaves; pairs are tried if something is
/// still open.
fn colour_then_pairs<'a>(
    searched: Searched<'a>,
    left: &[Vec<Vec<f64>>],
    context: &Context<'a>,
) -> Result<Weighed<'a>, FitError> {
    let settings = context.settings;
    let searched = match colour_of(&searched, &searched.noise, left) {
        Some(weights) => with_colour(searched, &weights, settings.finalists)?,
        None => searched,
    };
    let alone = Weighed::of(weigh_singles(searched, context.candidates)?, Vec::new(), settings);
    if is_open(&alone) { with_pairs(alone.singles, context) } else { Ok(alone) }
}

/// Pairs are tried at once; once more, where what the best of them leaves has a colour.
fn pairs_then_colour<'a>(
    searched: Searched<'a>,
    left: Vec<Vec<Vec<f64>>>,
    context: &Context<'a>,
) -> Result<Weighed<'a>, FitError> {
    let white = with_pairs(weigh_singles(searched, context.candidates)?, context)?;
    let answer = white.pairs.first().and_then(EffectSet::answer);
    let left = answer.map_or(left, |answer| answer.errors);
    let noise = with_slow(&white.singles.searched, &left)?;
    let searched = &white.singles.searched;
    let Some(weights) = colour_of(searched, &noise, &left) else { return Ok(white) };
    let searched = Searched { noise, ..white.singles.searched };
    let searched = with_colour(searched, &weights, context.settings.finalists)?;
    with_pairs(weigh_singles(searched, context.candidates)?, context)
}

/// Second causes are tried beside first ones, and single causes learn from them.
fn with_pairs<'a>(singles: Singles<'a>, context: &Context<'a>) -> Result<Weighed<'a>, FitError> {
    let mut pairs = seek_pairs(&singles, context);
    let singles = fitted_from(&pairs, singles, context)?;
    pairs.retain(EffectSet::are_all_there);
    Ok(Weighed::of(singles, pairs, context.settings))
}

/// Whether a single cause may not be all: something is left, or it is a free curve, which is no law,
/// and which two laws may draw; or what it leaves was taken for slow noise, which a second cause may be as well.
fn is_open(alone: &Weighed<'_>) -> bool {
    let Weighed { singles, best, lack_of_fit, .. } = alone;
    lack_of_fit.is_unexplained
        || STRONG < lack_of_fit.leftover.gain()
        || best.effects == 1
            && (singles.is_first_a_curve() || singles.searched.slow_noise(COLOURED).contains(&true))
}
