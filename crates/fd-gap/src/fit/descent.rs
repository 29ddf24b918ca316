//! A search for a minimum, step by step.

use std::ops::Range;

use fd_numeric::dot;

use super::{
    arrow::Arrow,
    columns::Columns,
    layout::{Layout, LeastSquares, Linearization},
    levenberg::{Minimum, Search},
};

/// Damping at the beginning, as a fraction of the diagonal of the normal equations.
const DAMPING: f64 = 1e-3;
/// Shorter steps that are looked at together.
const TOGETHER: usize = 4;
/// Part of the way to the edge of the box that counts as being there.
const EDGE: f64 = 1e-9;

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
pub(super) struct Setting {
    pub layout: Layout,
    bounds: Vec<[f64; 2]>,
    prior: Vec<[f64; 2]>,
    search: Search,
}

impl Setting {
    pub(super) fn of(problem: &dyn LeastSquares, search: Search) -> Self {
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

    pub(super) fn inside(&self, z: &[f64]) -> Vec<f64> {
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

/// Where a search wants to look next.
pub(super) enum Next {
    /// At a place, with slopes.
    Place(Vec<f64>),
    /// At the residuals of some steps, shorter and shorter.
    OneOf(Vec<Step>),
    /// It has come to its end.
    Nowhere,
}

/// A step that could be taken.
pub(super) struct Step {
    /// Where it leads.
    pub z: Vec<f64>,
    damping: f64,
    /// By how much the sum of squares falls, if residuals are linear; NaN where the step ends at the edge of the box.
    predicted: f64,
}

/// A search on its way down. It says where it wants to look next, and is told what is there. Damping falls the more, the better
/// a step was predicted, and grows faster and faster with steps that lead up (Nielsen; Madsen, Nielsen & Tingleff 2004, 3.16).
pub(super) struct Descent<'a> {
    setting: &'a Setting,
    pub at: Minimum,
    damping: f64,
    /// By how much the next step up will raise it.
    growth: f64,
    /// By how much the sum of squares falls with the step that was taken last, if residuals are linear.
    predicted: f64,
    /// Whether that led up.
    has_failed: bool,
    /// A shorter one that leads down.
    down: Option<Step>,
    /// Normal equations at this place, with held unknowns taken out.
    equations: Option<Arrow>,
    iterations: usize,
    secants: Option<Secants>,
}

impl<'a> Descent<'a> {
    pub(super) fn new(
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
        Self {
            setting,
            at,
            damping: DAMPING,
            growth: 2.0,
            predicted: 0.0,
            has_failed: false,
            down: None,
            equations: None,
            iterations: 0,
            secants: None,
        }
    }

    /// Where to look next.
    pub(super) fn next(&mut self) -> Next {
        if let Some(Step { z, damping, predicted }) = self.down.take() {
            (self.damping, self.predicted) = (damping, predicted);
            return Next::Place(z);
        }
        let Search { iterations, by_secants, .. } = self.setting.search;
        if self.at.converged || self.iterations == iterations {
            return Next::Nowhere;
        }
        let equations = match self.equations.take() {
            Some(equations) => equations,
            None => self.setting.linear_equations(&self.at, self.secants.as_ref()),
        };
        let next = if self.has_failed && !by_secants {
            let mut steps = Vec::with_capacity(TOGETHER);
            while steps.len() < TOGETHER {
                let Some(step) = self.step(&equations) else { break };
                steps.push(step);
                self.grow();
            }
            if steps.is_empty() { Next::Nowhere } else { Next::OneOf(steps) }
        } else {
            self.step(&equations).map_or(Next::Nowhere, |step| {
                self.predicted = step.predicted;
                Next::Place(step.z)
            })
        };
        self.equations = Some(equations);
        next
    }

    /// The step with the damping as it is, or with the least one above that makes the equations definite; `None` at the end.
    fn step(&mut self, equations: &Arrow) -> Option<Step> {
        while self.damping < self.setting.search.give_up {
            let mut damped = equations.clone();
            for i in 0..self.at.z.len() {
                *damped.diagonal_mut(i) *= 1.0 + self.damping;
            }
            let Some(factor) = damped.factor() else {
                self.grow();
                continue;
            };
            let mut step = equations.gradient.clone();
            factor.solve(&mut step);
            let predicted = dot(&step, &equations.gradient);
            if predicted < self.setting.negligible(self.at.cost) {
                self.at.converged = true;
                return None;
            }
            let held = step.iter().enumerate().map(|(i, s)| equations.diagonal(i) * s * s);
            let predicted = predicted + self.damping * held.sum::<f64>();
            let moved: Vec<f64> = self.at.z.iter().zip(&step).map(|(z, step)| z - step).collect();
            let z = self.setting.inside(&moved);
            // What ends at the edge of the box goes less far, and was not predicted.
            let is_cut = z.iter().zip(&moved).any(|(z, moved)| z.total_cmp(moved).is_ne());
            let predicted = if is_cut { f64::NAN } else { predicted };
            return Some(Step { z, damping: self.damping, predicted });
        }
        None
    }

    /// Goes on with the lowest of some steps, if that leads down.
    pub(super) fn choose(
        &mut self,
        steps: Vec<Step>,
        found: &mut impl Iterator<Item = Option<Linearization>>,
    ) {
        // What they converge to does not matter where one leads down.
        self.at.converged = false;
        let costs = steps.into_iter().zip(found).filter_map(|(step, there)| {
            let [cost, _] = self.setting.cost(&step.z, &there?.r);
            (cost < self.at.cost).then_some((cost, step))
        });
        let lowest = costs.min_by(|a, b| a.0.total_cmp(&b.0));
        self.down = lowest.map(|(_, step)| step);
    }

    /// Goes there if it is lower, and shortens the step if not.
    pub(super) fn look_at(
        &mut self,
        z: Vec<f64>,
        there: Option<Linearization>,
        first_column: usize,
    ) {
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
                // At most tenfold; what secants predict says little of them.
                let well = 1.0 - (2.0 * gain / self.predicted - 1.0).powi(3);
                self.damping *= if self.setting.search.by_secants { 0.1 } else { well.max(0.1) };
                self.growth = 2.0;
                (self.has_failed, self.equations) = (false, None);
                self.iterations += 1;
                return;
            }
        }
        self.has_failed = true;
        self.grow();
    }

    fn grow(&mut self) {
        self.damping *= if self.setting.search.by_secants { 10.0 } else { self.growth };
        self.growth *= 2.0;
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
