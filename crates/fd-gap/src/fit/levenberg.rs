//! Levenberg's and Marquardt's method in a box.

use std::sync::Arc;

use super::{
    arrow::Arrow,
    columns::Columns,
    descent::{Descent, Next, Setting},
    layout::{Layout, LeastSquares},
};

/// How long to search, and what to leave as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Most steps down.
    pub iterations: usize,
    /// Ends when the sum of squares falls by less than this …
    pub absolute: f64,
    /// … plus this fraction of it.
    pub relative: f64,
    /// The slopes of this many first shared unknowns, and those of the own ones, are not
    /// computed again, once they are known.
    pub frozen: usize,
    /// The shared unknowns stay where they are.
    pub own_only: bool,
    /// Damping at which it gives up.
    pub give_up: f64,
    /// Slopes are rough: steps go by what those before them have shown as well.
    pub by_secants: bool,
}

impl Default for Search {
    fn default() -> Self {
        Self::PLAIN
    }
}

impl Search {
    /// To a minimum that a further step would not change by a thousandth.
    pub const PLAIN: Self = Self {
        iterations: 30,
        absolute: 1e-3,
        relative: 1e-7,
        frozen: 0,
        own_only: false,
        give_up: 1e8,
        by_secants: false,
    };

    /// No step, but residuals and slopes.
    pub const LOOK: Self = Self { iterations: 0, ..Self::PLAIN };

    /// The same where a step is a run that is dear, and slopes are rough, so that steps go by secants: it ends a fiftieth
    /// of a nat before, and does not insist.
    #[must_use]
    pub fn of_dear_runs(self) -> Self {
        Self {
            iterations: self.iterations.min(15),
            absolute: self.absolute.max(0.04),
            relative: self.relative.max(1e-5),
            give_up: 1e3,
            by_secants: true,
            ..self
        }
    }
}

/// Residuals of so many rows and outputs are not kept with every candidate, of which there are thousands.
pub(crate) const LONG: usize = 10_000;

/// A place in the space of the unknowns, with what is known there.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// Scaled unknowns.
    pub z: Vec<f64>,
    /// Sum of squares of the residuals, and of the prior.
    pub cost: f64,
    /// The part of the prior.
    pub prior_cost: f64,
    /// Residuals. None where they are so long that simulating them again is better than to keep them.
    pub r: Vec<f64>,
    /// Slopes, column by column, at this place; frozen ones at the place where they were computed. None where only
    /// their scalar products were kept.
    pub slopes: Columns,
    /// These products.
    pub(super) products: Option<Arc<Arrow>>,
    /// Whether the search ended because it could not get lower.
    pub converged: bool,
}

impl Minimum {
    /// The same, whose slopes many fits will share.
    pub(crate) fn shared(mut self, problem: &dyn LeastSquares) -> Self {
        self.slopes = std::mem::take(&mut self.slopes).multiplied(problem.layout());
        self
    }

    /// The same without slopes, of which there are many, but with their scalar products, which is all that evidence
    /// and standard errors need; and without residuals that are long.
    pub(crate) fn condensed(mut self, problem: &dyn LeastSquares) -> Self {
        if self.products.is_none() {
            let slopes = std::mem::take(&mut self.slopes);
            self.products = Some(Arc::new(Arrow::of_slopes(problem.layout(), &slopes, &self.r)));
            if LONG < self.r.len() {
                self.r = Vec::new();
            }
        }
        self
    }

    /// The same with slopes, which are computed again if they were not kept; `None` where that fails.
    pub(crate) fn with_slopes(&self, problem: &mut dyn LeastSquares) -> Option<Self> {
        match self.products {
            None => Some(self.clone()),
            Some(_) => minimise(problem, &self.z, None, Search::LOOK),
        }
    }

    /// Normal equations at this place, with residuals and slopes multiplied by `weight`.
    pub(crate) fn equations(&self, problem: &dyn LeastSquares, weight: f64) -> Arrow {
        self.equations_in(problem.layout(), problem.prior(), weight)
    }

    pub(super) fn equations_in(&self, layout: &Layout, prior: &[[f64; 2]], weight: f64) -> Arrow {
        let known = self.products.as_deref().cloned();
        let products = known.unwrap_or_else(|| Arrow::of_slopes(layout, &self.slopes, &self.r));
        products.with_prior(prior, &self.z, weight)
    }
}

/// Minimises a sum of squares within its box, from `z` on. Where residuals are not finite the
/// cost is infinite, so that the step shrinks. Returns `None` when it is so at the start.
///
/// An unknown at the edge of its box that wants to get out stays there for the step; other steps
/// end at the edge (projected Levenberg-Marquardt; Nocedal & Wright 2006, sections 10.3, 16.7).
///
/// `slopes` of a nearby place may be given, for [`Search::frozen`].
///
/// # Panics
///
/// Panics when `z` does not have one value per unknown.
#[must_use]
pub fn minimise(
    problem: &mut dyn LeastSquares,
    z: &[f64],
    slopes: Option<&Columns>,
    search: Search,
) -> Option<Minimum> {
    minimise_all(problem, &[z.to_vec()], slopes, search).pop().flatten()
}

/// As [`minimise`], from several places, with the results that each would have alone. All searches
/// ask for their next residuals and slopes at once ([`LeastSquares::linearize`]): slopes at a place
/// that turns out worse are thrown away, but where several simulations run side by side they cost
/// little. Where a step led up, several shorter ones are looked at together, without slopes.
///
/// # Panics
///
/// Panics when a place does not have one value per unknown.
#[must_use]
pub fn minimise_all(
    problem: &mut dyn LeastSquares,
    starts: &[Vec<f64>],
    slopes: Option<&Columns>,
    search: Search,
) -> Vec<Option<Minimum>> {
    let setting = Setting::of(problem, search);
    let Layout { shared, own, .. } = setting.layout;
    let all = if search.own_only { shared..shared + own } else { 0..shared + own };
    let refreshed = match search {
        Search { frozen: 0, .. } => all.clone(),
        Search { frozen, .. } => frozen.min(shared)..shared,
    };
    // What stays frozen is computed once, unless it was given.
    let first = if slopes.is_some() { refreshed.clone() } else { all };
    let starts: Vec<Vec<f64>> = starts.iter().map(|z| setting.inside(z)).collect();
    let mut descents: Vec<Option<Descent<'_>>> = problem
        .linearize(&starts, first.clone())
        .into_iter()
        .zip(starts)
        .map(|(there, z)| Some(Descent::new(&setting, z, there?, first.clone(), slopes)))
        .collect();
    loop {
        let (mut places, mut steps) = (Vec::new(), Vec::new());
        let (mut looking, mut trying) = (Vec::new(), Vec::new());
        for descent in descents.iter_mut().flatten() {
            match descent.next() {
                Next::Place(place) => {
                    places.push(place);
                    looking.push(descent);
                }
                Next::OneOf(some) => {
                    steps.extend(some.iter().map(|step| step.z.clone()));
                    trying.push((descent, some));
                }
                Next::Nowhere => {}
            }
        }
        if places.is_empty() && steps.is_empty() {
            break;
        }
        let found = problem.linearize(&places, refreshed.clone());
        for ((descent, z), there) in looking.into_iter().zip(places).zip(found) {
            descent.look_at(z, there, refreshed.start);
        }
        let mut found = problem.linearize(&steps, 0..0).into_iter();
        for (descent, steps) in trying {
            descent.choose(steps, &mut found);
        }
    }
    descents.into_iter().map(|descent| descent.map(|descent| descent.at)).collect()
}
