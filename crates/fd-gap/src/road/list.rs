//! A list of causes, each patched into the model that has those before it.

use fd_effect::{Candidate, Suspects};
use fd_sim::model::Model;

use super::{adjustable::adjustable, beside::Beside, result::Milestone};
use crate::diagnose::{Cause, Settings};

/// A cause that was accepted, and the candidate that it is: its model has all causes so far, adjustable.
#[derive(Clone, Debug)]
pub(super) struct Listed {
    pub(super) milestone: Milestone,
    pub(super) candidate: Candidate,
}

impl Listed {
    /// Whether nothing beside the same others explained clearly better: a law that a curve without a law beats by far
    /// stands for something else.
    pub(super) fn is_credible(&self, settings: &Settings) -> bool {
        1.0 / settings.bayes_factor <= self.milestone.odds
    }
}

/// What lists are made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lists<'a> {
    /// All suspects of the study.
    pub(super) suspects: &'a dyn Suspects,
    /// The model as it came.
    pub(super) model: &'a Model,
    /// Its parameters: an error of a parameter of a cause is no cause.
    pub(super) parameters: &'a [String],
}

impl Lists<'_> {
    /// The model with all causes of a list in it.
    pub(super) fn model<'l>(&'l self, list: &'l [Listed]) -> &'l Model {
        list.last().map_or(self.model, |last| &last.candidate.model)
    }

    /// What can be tried beside a list.
    pub(super) fn beside<'l>(&'l self, list: &'l [Listed]) -> Beside<'l> {
        Beside { suspects: self.suspects, known: list, parameters: self.parameters, fitted: None }
    }

    /// The same causes with the values that they have in a model in which all were refitted.
    pub(super) fn settled(&self, list: &[Listed], fitted: &Model) -> Option<Vec<Listed>> {
        let settled = |listed: &Listed| {
            let mut milestone = listed.milestone.clone();
            for estimate in &mut milestone.cause.parameters {
                let same = fitted.parameter(&estimate.name);
                estimate.value = same.map_or(estimate.value, |same| same.value);
            }
            milestone
        };
        self.of(list.iter().map(settled))
    }

    /// The candidate that a cause is, on top of a list.
    pub(super) fn candidate(&self, list: &[Listed], cause: &Cause) -> Option<Candidate> {
        let is_it = |c: &Candidate| c.identity() == cause.identity() && c.law == cause.law;
        self.beside(list).alone().into_iter().flatten().find(is_it)
    }

    /// A cause on top of a list, adjustable around what was found of it; `None` if it cannot be there.
    pub(super) fn listed(&self, list: &[Listed], milestone: Milestone) -> Option<Listed> {
        let candidate = self.candidate(list, &milestone.cause)?;
        let model = adjustable(&candidate, &milestone.cause);
        let mut milestone = milestone;
        for (estimate, parameter) in
            milestone.cause.parameters.iter_mut().zip(&candidate.parameters)
        {
            estimate.name.clone_from(&parameter.name);
        }
        Some(Listed { milestone, candidate: Candidate { model, ..candidate } })
    }

    /// A list with one more cause, all of it as it was fitted together.
    pub(super) fn with(&self, list: Vec<Listed>, next: Listed) -> Vec<Listed> {
        let settled = self.settled(&list, &next.milestone.cause.model);
        let settled = settled.and_then(|mut settled| {
            let next = self.listed(&settled, next.milestone.clone())?;
            settled.push(next);
            Some(settled)
        });
        settled.unwrap_or_else(|| list.into_iter().chain([next]).collect())
    }

    /// The same causes, one on top of the other; `None` if one cannot be there without those that are missing.
    pub(super) fn of(
        &self,
        milestones: impl IntoIterator<Item = Milestone>,
    ) -> Option<Vec<Listed>> {
        milestones.into_iter().try_fold(Vec::new(), |mut list, milestone| {
            list.push(self.listed(&list, milestone)?);
            Some(list)
        })
    }
}
