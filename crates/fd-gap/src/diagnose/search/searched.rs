//! All candidates, fitted as far as it was worth it.

use std::sync::{Arc, OnceLock};

use fd_sim::model::Model;

use super::{changes::Changes, trial::Trial};
use crate::{
    diagnose::{prepare::noise::KnownNoise, result::NotTested},
    fit::{FitError, NullFit},
};

/// All candidates, fitted as far as it was worth it.
#[derive(Debug)]
pub(in crate::diagnose) struct Searched<'a> {
    /// The nominal model, with an integration step that is short enough for the finalists.
    pub model: Model,
    /// The fit without any effect.
    pub null: NullFit,
    pub noise: KnownNoise,
    /// Simulations that it took to see what each candidate promises.
    pub screening: usize,
    /// What candidates change, as far as they were looked at.
    pub changes: Arc<OnceLock<Changes>>,
    /// The fits, in the order of the candidates.
    pub trials: Vec<Trial<'a>>,
    pub not_tested: Vec<NotTested>,
    /// Whether the fits whiten errors: the noise has a colour.
    pub is_coloured: bool,
}

/// A trial of a search: its place in [`Searched::trials`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::diagnose) struct TrialId(usize);

impl<'a> Searched<'a> {
    /// All trials with their ids.
    pub(in crate::diagnose) fn trials(&self) -> impl Iterator<Item = (TrialId, &Trial<'a>)> {
        self.trials.iter().enumerate().map(|(place, trial)| (TrialId(place), trial))
    }

    /// All trials with their ids, to simulate with them.
    pub(in crate::diagnose) fn trials_mut(
        &mut self,
    ) -> impl Iterator<Item = (TrialId, &mut Trial<'a>)> {
        self.trials.iter_mut().enumerate().map(|(place, trial)| (TrialId(place), trial))
    }

    /// The trial of an id of this search, to simulate with it.
    pub(in crate::diagnose) fn trial_mut(&mut self, id: TrialId) -> &mut Trial<'a> {
        &mut self.trials[id.0]
    }

    /// The trial of an id of this search.
    pub(in crate::diagnose) fn trial(&self, id: TrialId) -> &Trial<'a> {
        &self.trials[id.0]
    }

    /// For which outputs the fits take what wanders for noise of unknown size: its innovation is less than this
    /// fraction of it.
    pub(in crate::diagnose) fn slow_noise(&self, innovation: f64) -> Vec<bool> {
        let colours = &self.null.problem.weights().colour;
        let wander = colours.iter().map(|colour| colour.innovation() < innovation);
        self.noise.slow.iter().zip(wander).map(|(is_slow, wanders)| *is_slow && wanders).collect()
    }

    /// What the best single fit leaves, in sigma.
    pub(in crate::diagnose) fn best_errors(&self) -> Result<Vec<Vec<Vec<f64>>>, FitError> {
        let best = self.trials.iter().min_by(|a, b| a.cost().total_cmp(&b.cost()));
        let errors = match best.and_then(|trial| Some((trial, trial.best.as_ref()?))) {
            Some((trial, best)) => trial.problem.clone().errors(&best.z),
            None => self.null.problem.clone().errors(&self.null.minimum.z),
        };
        errors.ok_or(FitError::Diverged)
    }
}
