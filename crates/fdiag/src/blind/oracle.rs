//! What could be told from a case without noise, by refits to its noise-free truth.

use std::sync::Arc;

use fd_gap::{
    effect::{Candidate, Kind, ReplayScales, library, offers},
    fit::{
        FitError, Horizon, LeastSquares, Minimum, NullFit, Plan, Problem, Projection, Search,
        Variable, Weights, minimise, null_fit,
    },
    model::{LoadError, Model},
    quality::Autoregression,
    simulate::EquationSimulator,
};
use fd_model::Record;
use serde::{Deserialize, Serialize};

use super::error::BlindError;

/// Squares of the noise below which two explanations are one.
pub(super) const SEPARATED: f64 = 9.0;

/// Starts of a law that are fitted.
const STARTS: usize = 2;
/// Laws that are fitted to the end.
const FINALISTS: usize = 12;
/// A first look at a law.
const SHORT: Search =
    Search { iterations: 4, absolute: 0.1, relative: 1e-4, frozen: usize::MAX, own_only: false };

/// What refits to the noise-free truth leave, in squares of the noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Oracle {
    /// By the nominal model with nuisances: below 9 the case is invisible.
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

/// All candidates of the library that can be simulated, for a model and a log.
pub(super) fn candidates(model: &Model, log: &Record) -> Result<Vec<Candidate>, BlindError> {
    let u: Vec<f64> = (0..log.len()).flat_map(|k| log.u(k).to_vec()).collect();
    let scales = ReplayScales::of(model, log.ts(), &u, log.len())?;
    let all = offers(&library(), model, &scales).into_iter().flatten();
    Ok(all.filter(|candidate| candidate.kind == Kind::Simulation).collect())
}

/// The null fit to a noise-free log, with the noise that the model states: white, or an AR(1)
/// sequence of this coefficient. In coloured noise slow differences are worth less.
pub(super) fn null(model: &Model, log: &Record, colour: f64) -> Result<NullFit, BlindError> {
    let simulator = EquationSimulator::<f64>::at(model, log.ts())?;
    let plan = Arc::new(Plan::new(&simulator, std::slice::from_ref(log), Horizon::FreeRun)?);
    let sigma = model.outputs.iter().map(|output| output.noise.unwrap_or(1.0)).collect();
    let mut weights = Weights::white(sigma);
    if colour != 0.0 {
        weights.colour.fill(Autoregression::first_order(colour));
    }
    Ok(null_fit(&plan, &simulator, &weights)?)
}

/// The model with real parameters and initial states for nominal ones: distances are measured from
/// where the truth is, as the tie test of the diagnosis does.
pub(super) fn centred(model: &Model, parameters: &[f64], x0: &[f64]) -> Result<Model, BlindError> {
    let mut draft = model.clone().into_draft();
    for (parameter, value) in draft.parameters.iter_mut().zip(parameters) {
        parameter.tolerance *= (parameter.value / value).abs();
        parameter.value = *value;
    }
    for (state, value) in draft.states.iter_mut().zip(x0) {
        state.initial = *value;
    }
    Model::try_from(draft).map_err(|error| {
        let file = "the model at the truth".to_owned();
        BlindError::Model { error: Box::new(LoadError::Model { file, error }) }
    })
}

/// Looks for everything in the library that explains a noise-free log.
pub(super) fn oracle(model: &Model, log: &Record, colour: f64) -> Result<Oracle, BlindError> {
    let null = null(model, log, colour)?;
    let nothing = null.minimum.cost;
    let mut oracle = Oracle { nothing, ..Oracle::default() };
    if nothing < SEPARATED {
        return Ok(oracle);
    }
    let candidates = candidates(model, log)?;
    let projection = projection(&null)?;
    let mut trials: Vec<(&Candidate, Problem, Minimum)> = candidates
        .iter()
        .filter_map(|candidate| {
            let (problem, minimum) = short(candidate, &null, &projection).ok()??;
            Some((candidate, problem, minimum))
        })
        .collect();
    trials.sort_by(|a, b| a.2.cost.total_cmp(&b.2.cost));
    let mut rivals: Vec<Rival> = Vec::new();
    for (candidate, mut problem, minimum) in trials.into_iter().take(FINALISTS) {
        let better = minimise(&mut problem, &minimum.z, None, Search::default());
        let distance = better.map_or(minimum.cost, |better| better.cost.min(minimum.cost));
        let rival = Rival { distance, ..Rival::of(candidate) };
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

/// The least that a named effect leaves, over all its laws and starts.
pub(super) fn distance_of(
    model: &Model,
    log: &Record,
    colour: f64,
    wanted: impl Fn(&Candidate) -> bool,
) -> Result<f64, BlindError> {
    let null = null(model, log, colour)?;
    let projection = projection(&null)?;
    let mut least = null.minimum.cost;
    for candidate in candidates(model, log)?.iter().filter(|candidate| wanted(candidate)) {
        let Ok(Some((mut problem, minimum))) = short(candidate, &null, &projection) else {
            continue;
        };
        least = least.min(minimum.cost);
        if let Some(better) = minimise(&mut problem, &minimum.z, None, Search::default()) {
            least = least.min(better.cost);
        }
    }
    Ok(least)
}

fn projection(null: &NullFit) -> Result<Projection<'_>, BlindError> {
    Ok(Projection::new(&null.problem, &null.minimum).ok_or(FitError::Diverged)?)
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

/// The best of short fits from the starts that promise most.
fn short(
    candidate: &Candidate,
    null: &NullFit,
    projection: &Projection<'_>,
) -> Result<Option<(Problem, Minimum)>, FitError> {
    let plan = Arc::clone(null.problem.plan());
    let ts = null.problem.simulator().ts();
    let simulator = EquationSimulator::<f64>::at(&candidate.model, ts).map_err(FitError::from)?;
    let variables = candidate.parameters.iter().map(Variable::effect);
    let weights = null.problem.weights().clone();
    let mut problem = Problem::new(plan, Box::new(simulator), variables.collect(), weights)?;
    let mut r = vec![0.0; problem.layout().residuals()];
    let mut scored: Vec<(f64, &Vec<f64>)> = Vec::new();
    for start in &candidate.starts {
        let z = problem.place(&null.minimum.z, start);
        if problem.residuals(&z, &mut r) {
            scored.push((projection.score(&r, [-4.0, 4.0]).gain, start));
        }
    }
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let shared = null.problem.layout().shared;
    let mut best: Option<Minimum> = None;
    for (_, start) in scored.into_iter().take(STARTS) {
        let z = problem.place(&null.minimum.z, start);
        let mut slopes = null.minimum.slopes.clone();
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
    Ok(best.map(|best| (problem, best)))
}
