//! Fits to the noise-free log of a case, of the nominal model and of candidates.

use std::sync::Arc;

use fd_effect::{Candidate, EverySite, Kind, Offers, library};
use fd_gap::{
    fit::{
        FitError, Horizon, LeastSquares, Minimum, NullFit, Plan, Problem, Search, Surroundings,
        Variable, Weights, minimise, null_fit,
    },
    quality::Autoregression,
};
use fd_model::Record;
use fd_sim::{
    model::Model,
    scales::ReplayScales,
    simulate::{LoggedLoop, Nominal},
};

use super::{
    error::BlindError,
    plants::{Tuning, looped},
    truth::Scene,
};

/// Starts of a law that are fitted.
const STARTS: usize = 2;
/// Laws that are fitted to the end.
const FINALISTS: usize = 12;
/// A first look at a law.
const SHORT: Search =
    Search { iterations: 4, absolute: 0.1, relative: 1e-4, frozen: usize::MAX, ..Search::PLAIN };

/// A model and a noise-free log, as a diagnosis would look at them: where the noise goes round the
/// loop, with the controller on the logged outputs.
pub(super) struct Sight<'a> {
    model: &'a Model,
    logged: Option<LoggedLoop<'a>>,
    /// The log; of an unstable plant, one after the other, its windows.
    logs: Vec<Record>,
    scales: ReplayScales,
    colour: f64,
}

/// A candidate with its best fit.
pub(super) struct Fitted {
    pub candidate: Candidate,
    problem: Problem,
    pub minimum: Minimum,
}

/// The null fit to a log, with the noise that the model states: white, or an AR(1) sequence of this
/// coefficient. In coloured noise slow differences are worth less.
pub(super) fn null(
    nominal: &dyn Nominal,
    model: &Model,
    logs: &[Record],
    colour: f64,
) -> Result<NullFit, BlindError> {
    let ts = logs.first().ok_or(FitError::NoLog)?.ts();
    let simulator = nominal.patched(model, ts)?;
    let plan = Arc::new(Plan::new(&*simulator, logs, Horizon::FreeRun)?);
    let sigma = model.outputs.iter().map(|output| output.noise.unwrap_or(1.0)).collect();
    let mut weights = Weights::white(sigma);
    if colour != 0.0 {
        weights.colour.fill(Autoregression::first_order(colour));
    }
    Ok(null_fit(&plan, &*simulator, &weights)?)
}

/// Those of some candidates that can be simulated.
pub(super) fn simulated(offers: Offers) -> impl Iterator<Item = Candidate> {
    offers.into_iter().flatten().filter(|candidate| candidate.kind == Kind::Simulation)
}

impl<'a> Sight<'a> {
    /// `model` is that of the scene, or that with other values.
    pub(super) fn new(
        scene: &Scene<'_>,
        model: &'a Model,
        log: &Record,
    ) -> Result<Self, BlindError> {
        let window = Self::window(scene).unwrap_or(log.len()).min(log.len());
        let u: Vec<f64> = (0..window).flat_map(|k| log.u(k).to_vec()).collect();
        let scales = ReplayScales::of(model, log.ts(), &u, window)?;
        let in_loop = scene.plant.noise_in_loop;
        let logged = if in_loop { LoggedLoop::of(model, log.ts()) } else { None };
        let log = match &logged {
            Some(logged) => logged.record(log)?,
            None => log.clone(),
        };
        let windows =
            (0..log.len() / window.max(1)).map(|i| log.slice(i * window, (i + 1) * window));
        let colour = scene.truth.colour();
        Ok(Self { model, logged, logs: windows.collect(), scales, colour })
    }

    /// Samples for which an unstable plant can be simulated without its controller.
    pub(super) fn window(scene: &Scene<'_>) -> Option<usize> {
        scene.truth.conditions.controller.as_ref()?;
        match looped(scene.plant)?.tuning {
            Tuning::Fixed { window, .. } => window,
            Tuning::Relative => None,
        }
    }

    fn nominal(&self) -> &dyn Nominal {
        match &self.logged {
            Some(logged) => logged,
            None => self.model,
        }
    }

    /// The fit without any effect; `None` when the model diverges without it.
    pub(super) fn null(&self) -> Result<Option<NullFit>, BlindError> {
        match null(self.nominal(), self.model, &self.logs, self.colour) {
            Err(BlindError::Fit(error)) if *error == FitError::Diverged => Ok(None),
            found => found.map(Some),
        }
    }

    /// The library at every site.
    pub(super) fn suspects(&self) -> EverySite<'_> {
        EverySite::new(library(), self.model, self.scales.clone())
    }

    /// The candidates that promise most besides a fit, fitted to the end, the best first; none where
    /// the equations of that fit are singular.
    pub(super) fn fitted(
        &self,
        candidates: impl Iterator<Item = Candidate>,
        base: &NullFit,
    ) -> Vec<Fitted> {
        let Some(around) = Surroundings::new(&base.problem, &base.minimum) else {
            return vec![];
        };
        let mut all: Vec<Fitted> =
            candidates.filter_map(|candidate| self.short(candidate, base, &around).ok()?).collect();
        let by_cost = |a: &Fitted, b: &Fitted| a.minimum.cost.total_cmp(&b.minimum.cost);
        all.sort_by(by_cost);
        all.truncate(FINALISTS);
        for Fitted { problem, minimum, .. } in &mut all {
            let better = minimise(problem, &minimum.z, None, Search::default());
            if let Some(better) = better.filter(|better| better.cost < minimum.cost) {
                *minimum = better;
            }
        }
        all.sort_by(by_cost);
        all
    }

    /// The best of short fits from the starts that promise most.
    fn short(
        &self,
        candidate: Candidate,
        base: &NullFit,
        around: &Surroundings<'_>,
    ) -> Result<Option<Fitted>, FitError> {
        let plan = Arc::clone(base.problem.plan());
        let ts = base.problem.simulator().ts();
        let simulator = self.nominal().patched(&candidate.model, ts)?;
        let variables = candidate.parameters.iter().map(Variable::effect);
        let weights = base.problem.weights().clone();
        let mut problem = Problem::new(plan, simulator, variables.collect(), weights)?;
        let mut r = vec![0.0; problem.layout().residuals()];
        let mut scored: Vec<(f64, &Vec<f64>)> = Vec::new();
        let before = &base.minimum.r;
        let change = |r: &[f64]| -> Vec<f64> { r.iter().zip(before).map(|(r, b)| r - b).collect() };
        for start in &candidate.starts {
            let z = problem.place(&base.minimum.z, start);
            if problem.residuals(&z, &mut r)
                && let Some(score) = around.score(&change(&r), [-4.0, 4.0])
            {
                scored.push((score.left, start));
            }
        }
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        let shared = base.problem.layout().shared;
        let mut best: Option<Minimum> = None;
        for (_, start) in scored.into_iter().take(STARTS) {
            let z = problem.place(&base.minimum.z, start);
            let mut slopes = base.minimum.slopes.clone();
            let rows = problem.layout().residuals();
            slopes.splice(shared..shared, vec![vec![0.0; rows]; candidate.parameters.len()]);
            let found = if shared == 0 {
                minimise(&mut problem, &z, None, SHORT)
            } else {
                minimise(&mut problem, &z, Some(&slopes), Search { frozen: shared, ..SHORT })
            };
            if let Some(found) = found
                && best.as_ref().is_none_or(|best| found.cost < best.cost)
            {
                best = Some(found);
            }
        }
        Ok(best.map(|minimum| Fitted { candidate, problem, minimum }))
    }
}

impl Fitted {
    /// The fit with the effect taken for granted: its parameters are among the nuisances.
    pub(super) fn granted(&self) -> Result<NullFit, FitError> {
        let problem = &self.problem;
        let plan = Arc::new(problem.plan().with_parameters(problem.effects()));
        let (simulator, weights) = (problem.simulator().boxed(), problem.weights().clone());
        let problem = Problem::new(plan, simulator, vec![], weights)?;
        Ok(NullFit { problem, minimum: self.minimum.clone() })
    }
}
