//! Levenberg's and Marquardt's method in a box.

use std::{ops::Range, sync::Arc};

use fd_numeric::dot;

use super::{
    arrow::Arrow,
    columns::Columns,
    layout::{Layout, LeastSquares, Linearization},
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
    /// Damping at which it gives up; it grows tenfold with each step that leads up.
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

/// Damping at the beginning, as a fraction of the diagonal of the normal equations.
const DAMPING: f64 = 1e-3;
/// Damping that is as good as none.
const LOWEST_DAMPING: f64 = 1e-9;
/// Part of the way to the edge of the box that counts as being there.
const EDGE: f64 = 1e-9;

/// Residuals of so many rows and outputs are not kept with every candidate, of which there are thousands.
const LONG: usize = 10_000;

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
    products: Option<Arc<Arrow>>,
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
            Some(_) => minimise(problem, &self.z, None, Search { iterations: 0, ..Search::PLAIN }),
        }
    }

    /// Normal equations at this place, with residuals and slopes multiplied by `weight`.
    pub(crate) fn equations(&self, problem: &dyn LeastSquares, weight: f64) -> Arrow {
        self.equations_in(problem.layout(), problem.prior(), weight)
    }

    fn equations_in(&self, layout: &Layout, prior: &[[f64; 2]], weight: f64) -> Arrow {
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
/// little.
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
        let (mut places, mut active) = (Vec::new(), Vec::new());
        for descent in descents.iter_mut().flatten() {
            if let Some(place) = descent.next_place() {
                places.push(place);
                active.push(descent);
            }
        }
        if places.is_empty() {
            break;
        }
        let found = problem.linearize(&places, refreshed.clone());
        for ((descent, z), there) in active.into_iter().zip(places).zip(found) {
            descent.look_at(z, there, refreshed.start);
        }
    }
    descents.into_iter().map(|descent| descent.map(|descent| descent.at)).collect()
}

/// By how much the sum of squares at a place would fall if residuals were as linear as their slopes say.
pub(crate) fn promised(problem: &dyn LeastSquares, at: &Minimum) -> f64 {
    let setting = Setting::of(problem, Search::PLAIN);
    let equations = setting.linear_equations(at, None);
    let Some(factor) = equations.factor() else { return f64::INFINITY };
    let mut step = equations.gradient.clone();
    factor.solve(&mut step);
    dot(&step, &equations.gradient)
}

/// What all searches of a problem have in common.
struct Setting {
    layout: Layout,
    bounds: Vec<[f64; 2]>,
    prior: Vec<[f64; 2]>,
    search: Search,
}

impl Setting {
    fn of(problem: &dyn LeastSquares, search: Search) -> Self {
        Self {
            layout: problem.layout().clone(),
            bounds: problem.bounds().to_vec(),
            prior: problem.prior().to_vec(),
            search,
        }
    }

    /// Normal equations at a place, by secants where there are any, with held unknowns taken out.
    fn linear_equations(&self, at: &Minimum, secants: Option<&Secants>) -> Arrow {
        let Self { layout, bounds, prior, search } = self;
        let z = &at.z;
        let mut equations = match secants {
            Some(Secants(slopes)) => {
                Arrow::of_slopes(layout, slopes, &at.r).with_prior(prior, z, 1.0)
            }
            None => at.equations_in(layout, prior, 1.0),
        };
        for (i, [low, high]) in bounds.iter().enumerate() {
            let (edge, slope) = (EDGE * (high - low), equations.gradient[i]);
            let is_held = search.own_only && i < layout.shared
                || z[i] <= low + edge && 0.0 <= slope
                || high - edge <= z[i] && slope <= 0.0;
            if is_held || *equations.diagonal_mut(i) <= 0.0 {
                equations.fix(i);
            }
        }
        equations
    }

    fn inside(&self, z: &[f64]) -> Vec<f64> {
        assert_eq!(z.len(), self.layout.unknowns(), "one start per unknown");
        z.iter().zip(&self.bounds).map(|(z, [low, high])| z.clamp(*low, *high)).collect()
    }

    /// Sum of squares, and the part of the prior.
    fn cost(&self, z: &[f64], r: &[f64]) -> [f64; 2] {
        let prior = self.prior.iter().zip(z).map(|([m, p], z)| p * (z - m).powi(2)).sum::<f64>();
        [r.iter().map(|r| r * r).sum::<f64>() + prior, prior]
    }

    /// A gain that is not worth another step.
    fn negligible(&self, cost: f64) -> f64 {
        self.search.absolute + self.search.relative * cost
    }
}

/// A search on its way down. It says where it wants to look next, and is told what is there.
struct Descent<'a> {
    setting: &'a Setting,
    at: Minimum,
    damping: f64,
    /// Normal equations at this place, with held unknowns taken out.
    equations: Option<Arrow>,
    iterations: usize,
    secants: Option<Secants>,
}

impl<'a> Descent<'a> {
    fn new(
        setting: &'a Setting,
        z: Vec<f64>,
        there: Linearization,
        columns: Range<usize>,
        known: Option<&Columns>,
    ) -> Self {
        let [cost, prior_cost] = setting.cost(&z, &there.r);
        let rows = there.r.len();
        let all = setting.layout.shared + setting.layout.own;
        let mut slopes = known.cloned().unwrap_or_else(|| Columns::new(vec![vec![0.0; rows]; all]));
        slopes.splice(columns, there.slopes);
        let (r, converged, products) = (there.r, false, None);
        let at = Minimum { z, cost, prior_cost, r, slopes, products, converged };
        Self { setting, at, damping: DAMPING, equations: None, iterations: 0, secants: None }
    }

    /// Where to look next; `None` at the end.
    fn next_place(&mut self) -> Option<Vec<f64>> {
        let Search { iterations, give_up, .. } = self.setting.search;
        let is_over = self.at.converged || self.iterations == iterations;
        if is_over || give_up <= self.damping {
            return None;
        }
        let equations = match self.equations.take() {
            Some(equations) => equations,
            None => self.setting.linear_equations(&self.at, self.secants.as_ref()),
        };
        let mut next = None;
        while next.is_none() && self.damping < give_up {
            let mut damped = equations.clone();
            for i in 0..self.at.z.len() {
                *damped.diagonal_mut(i) *= 1.0 + self.damping;
            }
            let Some(factor) = damped.factor() else {
                self.damping *= 10.0;
                continue;
            };
            let mut step = equations.gradient.clone();
            factor.solve(&mut step);
            let predicted = dot(&step, &equations.gradient);
            if predicted < self.setting.negligible(self.at.cost) {
                self.at.converged = true;
                return None;
            }
            let moved: Vec<f64> = self.at.z.iter().zip(&step).map(|(z, step)| z - step).collect();
            next = Some(self.setting.inside(&moved));
        }
        self.equations = Some(equations);
        next
    }

    /// Goes there if it is lower, and shortens the step if not.
    fn look_at(&mut self, z: Vec<f64>, there: Option<Linearization>, first_column: usize) {
        if let Some(there) = there {
            let [cost, prior_cost] = self.setting.cost(&z, &there.r);
            if self.setting.search.by_secants {
                let secants = self.secants.take();
                let mut secants = secants.unwrap_or_else(|| Secants(self.at.slopes.clone()));
                secants.learn(&self.setting.layout, &self.at, (&z, &there.r));
                self.secants = Some(secants);
                self.equations = None;
            }
            if cost < self.at.cost {
                let gain = self.at.cost - cost;
                let columns = first_column..first_column + there.slopes.len();
                self.at.slopes.splice(columns, there.slopes);
                (self.at.z, self.at.r) = (z, there.r);
                (self.at.cost, self.at.prior_cost) = (cost, prior_cost);
                self.at.converged = gain <= self.setting.negligible(cost);
                self.damping = (self.damping / 10.0).max(LOWEST_DAMPING);
                self.equations = None;
                self.iterations += 1;
                return;
            }
        }
        self.damping *= 10.0;
    }
}

/// Slopes that steps have shown: Broyden's update, the least change of slopes that agrees with the last step, where each
/// unknown is measured by what it does to the residuals (Dennis & Schnabel 1996, section 8.1 and theorem 8.2.2).
struct Secants(Columns);

impl Secants {
    fn learn(&mut self, layout: &Layout, from: &Minimum, (z, r): (&[f64], &[f64])) {
        let mut slopes: Vec<Vec<f64>> = self.0.iter().map(<[f64]>::to_vec).collect();
        for (s, rows) in layout.segments.iter().enumerate() {
            let own = layout.first_own(s);
            let unknowns = (0..layout.shared).chain(own..own + layout.own);
            let step: Vec<f64> = unknowns.map(|i| z[i] - from.z[i]).collect();
            let here = slopes.iter().map(|column| &column[rows.clone()]);
            let along: Vec<f64> =
                here.zip(&step).map(|(column, step)| dot(column, column) * step).collect();
            let length = dot(&along, &step);
            if length.is_nan() || length <= 0.0 {
                continue;
            }
            for row in rows.clone() {
                let foretold: f64 = slopes.iter().zip(&step).map(|(c, step)| c[row] * step).sum();
                let missing = r[row] - from.r[row] - foretold;
                for (column, along) in slopes.iter_mut().zip(&along) {
                    column[row] += missing * along / length;
                }
            }
        }
        self.0 = Columns::new(slopes);
    }
}
