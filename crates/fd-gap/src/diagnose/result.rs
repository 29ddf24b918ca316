//! What a diagnosis says.

use crate::{
    effect::{Side, SiteRef},
    fit::Horizon,
    quality::Finding,
    shrink::Closed,
};

/// The answer to: which effect, how sure, how far does the gap shrink?
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// Probability that the nominal model, with its parameters refitted, explains the log.
    pub no_gap: f64,
    /// Causes, the most probable first.
    pub causes: Vec<Cause>,
    /// Places in `causes` of the causes that this log cannot tell from the first one, which is the
    /// first of them: refitted to its noise-free simulation they leave less than 9 squares of the
    /// noise.
    pub tied: Vec<usize>,
    /// Places in `causes` of other causes within the Bayes factor, with the squares of the noise
    /// that a refit leaves.
    pub rivals: Vec<(usize, f64)>,
    /// Noise of each output that residuals are measured in, in its unit.
    pub sigma: Vec<f64>,
    /// Noise floor of each output below the best cause, in sigma.
    pub floor: Vec<f64>,
    /// Root mean square of the training residual of each output, in sigma: parameters refitted.
    pub refit_gap: Vec<f64>,
    /// The same with the best cause.
    pub best_gap: Vec<f64>,
    /// Whether the best cause leaves clearly more than the floor (`ln` of the ratio above 0.2 in
    /// some output): the probabilities are then too sure of themselves.
    pub is_unexplained: bool,
    /// Whether the noise was found to be coloured.
    pub is_coloured: bool,
    /// Refitted parameters of the model with the best cause: name, value, deviation from nominal
    /// in standard deviations of the prior.
    pub nuisances: Vec<(String, f64, f64)>,
    /// Held-out gaps, one per horizon that could be computed.
    pub held_out: Vec<HeldOut>,
    /// What is wrong with the logs.
    pub findings: Vec<Finding>,
    /// Candidates that could not be tried: place, reason.
    pub not_tested: Vec<(usize, String)>,
    /// Simulations of all logs that were made.
    pub simulations: usize,
}

/// An effect at a site, all of its laws together.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// Label of the effect.
    pub label: &'static str,
    /// Where it is.
    pub site: SiteRef,
    /// The other end of a coupling.
    pub partner: Option<SiteRef>,
    /// Mechanism.
    pub family: &'static str,
    /// Side of the plant.
    pub side: Side,
    /// Probability.
    pub probability: f64,
    /// Logarithm of the evidence over that of "no gap".
    pub log_evidence: f64,
    /// Law with the most evidence.
    pub law: &'static str,
    /// Place of that law among the candidates.
    pub candidate: usize,
    /// Parameters of that law.
    pub parameters: Vec<Estimate>,
    /// Root mean square of the training residual of that law, in sigma.
    pub gap: f64,
}

/// A fitted parameter of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Name in the patched model.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Standard error, with everything else unknown as well.
    pub standard_error: f64,
    /// Whether it is a strength.
    pub is_strength: bool,
}

/// The gap on held-out data at one horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// Horizon.
    pub horizon: Horizon,
    /// Root mean square error of each output with nominal parameters, in its unit.
    pub nominal: Vec<f64>,
    /// With refitted parameters.
    pub refit: Vec<f64>,
    /// With the best cause.
    pub after: Vec<f64>,
    /// Noise floor.
    pub floor: Vec<f64>,
    /// Share of the reducible gap of the nominal model that is closed.
    pub closed_of_nominal: Option<Closed>,
    /// Share of the reducible gap of the refitted model that is closed.
    pub closed_of_refit: Option<Closed>,
}
