//! The result of a diagnosis.

mod held_out;

use std::fmt::{self, Display, Formatter};

use fd_effect::{Candidate, NotTestable, Side, SiteRef};
use fd_model::Record;
use fd_sim::model::Model;
use schemars::JsonSchema;
use serde::Serialize;

use super::{case::Case, objection::Objection, settings::Beginning};
use crate::{estimate::Calibrated, fit::Horizon, quality::Finding};

pub use self::held_out::HeldOut;

/// The answer to: which effect, how sure, how far does the gap shrink?
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[expect(clippy::struct_excessive_bools, reason = "facts that do not depend on each other")]
pub struct Diagnosis {
    /// The answer in one word.
    pub verdict: Verdict,
    /// What the probabilities rest on.
    pub regime: Regime,
    /// Whether the controller in the loop was run on the logged outputs ([`LoggedLoop`](fd_sim::simulate::LoggedLoop)).
    /// Explanations and held-out gaps are of the simulator as it came, with its loop closed.
    pub is_logged_loop: bool,
    /// Whether it can be: the controller of the model acts at samples of the logs.
    pub can_see_the_log: bool,
    /// Probability that the nominal model, with its parameters refitted, explains the log.
    pub no_gap: f64,
    /// Probability that no cause that was tried, nor a pair of them, is the right one.
    pub none_of_these: f64,
    /// Single causes, the most probable first.
    pub causes: Vec<Cause>,
    /// Mechanisms at places, the most probable first: sums over `causes` and `pairs`. As two
    /// mechanisms may be at work together, probabilities of groups may add up to more than 1.
    pub groups: Vec<Group>,
    /// Sides of the plant, the most probable first; sums as those of `groups`.
    pub sides: Vec<SideShare>,
    /// The causes that this log cannot tell from the first one, which is the first of them: refitted
    /// to its noise-free simulation they leave less than 9 squares of the noise.
    pub tied: Vec<CauseId>,
    /// Other causes within the Bayes factor, which the log does tell from the first one.
    pub rivals: Vec<RivalCause>,
    /// Pairs of causes that act together, the best first; empty when none was worth a try.
    pub pairs: Vec<Pair>,
    /// The pairs that this log cannot tell from the first one, which is the first of them.
    pub tied_pairs: Vec<PairId>,
    /// Why to doubt that the best explanation is all there is.
    pub leftover: Leftover,
    /// Noise of each output that residuals are measured in, in its unit.
    pub sigma: Vec<f64>,
    /// Step of the grid that the logged values of each output lie on, in its unit, where that is more than half the
    /// noise. It is part of the noise, and no cause: a log shows it, nobody has to infer it.
    pub steps: Vec<Option<f64>>,
    /// Noise floor of each output below the best explanation, in sigma.
    pub floor: Vec<f64>,
    /// Whether the best explanation leaves clearly more than the floor (`ln` of the ratio above
    /// 0.2 in some output).
    pub is_unexplained: bool,
    /// Whether the noise was found to be coloured.
    pub is_coloured: bool,
    /// Outputs of which nobody states the noise, and whose slow errors count as noise because nothing that was
    /// logged foretells them.
    pub slow_noise: Vec<bool>,
    /// The nominal model as it came.
    pub nominal: Explanation,
    /// The nominal model with its parameters refitted.
    pub refit: Explanation,
    /// The best explanation: with the cause, or the pair of causes, that the verdict names; that
    /// of `refit` when there is no gap, and with the first cause when none of them is right.
    pub best: Explanation,
    /// The uncertain parameters with the best explanation, and what the logs say of each.
    pub parameters: Vec<Calibrated>,
    /// What speaks against the answer, those that forbid it first.
    pub objections: Vec<Objection>,
    /// Held-out gaps, one per horizon that could be computed.
    pub held_out: Vec<HeldOut>,
    /// What is wrong with the logs; not serialised, as a report has it under the names of the files.
    #[serde(skip)]
    pub findings: Vec<Finding>,
    /// What has no fit, and why.
    pub not_tested: Vec<NotTested>,
    /// Parameters that are not known exactly and move no output in these logs: nothing here speaks of their values.
    pub idle: Vec<String>,
    /// Whether logs were taken to begin in motion, wherever the model says that they begin; not serialised.
    #[serde(skip)]
    pub is_in_motion: bool,
    /// Windows that fits were made in, where free runs are lost even with the best law; not serialised.
    #[serde(skip)]
    pub windows: Option<Horizon>,
    /// The fitted logs without the samples that are wrong by accident, where there are such; not serialised.
    #[serde(skip)]
    pub cleaned: Option<Vec<Record>>,
    /// Whether it was stopped before its end: causes and pairs may be missing.
    pub is_stopped: bool,
    /// Simulations of all logs that were made.
    pub simulations: usize,
}

impl Diagnosis {
    /// The cause of an id; `None` when the id is of another diagnosis.
    #[must_use]
    pub fn cause(&self, id: CauseId) -> Option<&Cause> {
        self.causes.get(id.0)
    }

    /// The pair of an id; `None` when the id is of another diagnosis.
    #[must_use]
    pub fn pair(&self, id: PairId) -> Option<&Pair> {
        self.pairs.get(id.0)
    }

    /// Probability that a cause is at work, alone or as one of two.
    #[must_use]
    pub fn at_work(&self, cause: &Cause) -> f64 {
        cause.at_work(&self.pairs)
    }

    /// Whether what is named explains the gap down to the noise.
    #[must_use]
    pub fn names_all(&self) -> bool {
        let is_named = matches!(self.verdict, Verdict::Cause | Verdict::Tied | Verdict::Pair);
        is_named && self.explains_all()
    }

    /// A case as it was diagnosed, for what is asked next: without samples that are wrong by accident.
    #[must_use]
    pub fn as_diagnosed<'a>(&'a self, case: &Case<'a>) -> Case<'a> {
        self.cleaned.as_ref().map_or(*case, |logs| Case { logs, ..*case })
    }

    /// Where it took the logs to begin.
    pub(crate) fn beginning(&self) -> Beginning {
        if self.is_in_motion { Beginning::InMotion } else { Beginning::AsStated }
    }

    /// Whether the best explanation comes down to the noise, named or not.
    #[must_use]
    pub fn explains_all(&self) -> bool {
        self.regime != Regime::AboveTheFloor && !self.is_unexplained
    }
}

/// A cause of a diagnosis: its place in [`Diagnosis::causes`], from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
pub struct CauseId(pub usize);

/// A pair of a diagnosis: its place in [`Diagnosis::pairs`], from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
pub struct PairId(pub usize);

impl Display for CauseId {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Display for PairId {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// The answer in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The nominal model, with its parameters refitted, explains the logs.
    NoGap,
    /// The first of the causes.
    Cause,
    /// One of the tied causes: this log cannot tell which.
    Tied,
    /// The first of the pairs.
    Pair,
    /// There is a gap, and nothing in the library explains it.
    NoneOfThese,
    /// There may be a gap, and several causes that could be told apart are about as probable.
    Unclear,
}

/// What the probabilities rest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Regime {
    /// The best explanation reaches the noise: evidence of the likelihood.
    AtTheFloor,
    /// Nothing reaches the noise, of the fitted logs or of those held out, and likelihoods would be absurdly sure: how often a
    /// law forecasts best, on blocks of the logs drawn with replacement, up to the share of the variance that it surely explains
    /// there.
    AboveTheFloor,
}

/// A mechanism at a place.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Group {
    /// Mechanism.
    pub family: &'static str,
    /// Where it is.
    pub site: SiteRef,
    /// Side of the plant.
    pub side: Side,
    /// Probability that it is at work, alone or as one of two.
    pub probability: f64,
    /// Its causes.
    pub causes: Vec<CauseId>,
}

/// A side of the plant, with all that is at work there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SideShare {
    /// The side.
    pub side: Side,
    /// Probability that something is at work there, alone or as one of two.
    pub probability: f64,
}

/// A cause that is nearly as probable as the first one, and can be told from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RivalCause {
    /// The cause.
    pub cause: CauseId,
    /// Squares of the noise that it leaves when it is refitted to the noise-free simulation of the
    /// first one.
    pub distance: f64,
}

/// An effect at a site, all of its laws together.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Cause {
    /// Label of the effect.
    pub label: &'static str,
    /// Where it is.
    pub site: SiteRef,
    /// The other end of a coupling.
    pub partner: Option<SiteRef>,
    /// Mechanism; for a map, that of the named laws which depend on the same quantity.
    pub family: &'static str,
    /// Side of the plant.
    pub side: Side,
    /// Probability.
    pub probability: f64,
    /// Natural logarithm of the evidence over that of "no gap".
    pub log_evidence: f64,
    /// Law with the most evidence.
    pub law: &'static str,
    /// Parameters of that law.
    pub parameters: Vec<Estimate>,
    /// Root mean square of the training residual of that law, in sigma.
    pub gap: f64,
    /// The model with that law in it, all values settled; not serialised.
    #[serde(skip)]
    pub model: Model,
}

impl Cause {
    /// What makes it this cause: label, site and partner, as of the
    /// [`Candidate`]s that are its laws.
    #[must_use]
    pub fn identity(&self) -> (&'static str, &SiteRef, Option<&SiteRef>) {
        (self.label, &self.site, self.partner.as_ref())
    }

    /// Its probability, and that of those of the pairs that it is part of.
    pub(super) fn at_work(&self, pairs: &[Pair]) -> f64 {
        let is_in = |pair: &&Pair| pair.causes.iter().any(|of| of.identity() == self.identity());
        self.probability + pairs.iter().filter(is_in).map(|pair| pair.probability).sum::<f64>()
    }
}

/// Two causes that act together.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Pair {
    /// The causes, with the parameters of the joint fit; the model is that with both.
    pub causes: [Cause; 2],
    /// Probability.
    pub probability: f64,
    /// Natural logarithm of the evidence over that of "no gap".
    pub log_evidence: f64,
    /// Root mean square of the training residual, in sigma.
    pub gap: f64,
}

/// What the best explanation leaves, beyond noise of the stated kind. Both are gains of the
/// (natural) log-likelihood that something else could have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Leftover {
    /// From residuals that have a colour and are stronger than the noise.
    pub level: f64,
    /// From a few functions of inputs, outputs and time that still predict residuals.
    pub pattern: f64,
    /// Share of the amplitude of the reducible gap of the refitted model that is left.
    pub share: f64,
}

impl Leftover {
    /// Log-likelihood that something else could gain.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.level + self.pattern
    }
}

impl Cause {
    /// Its largest strength in standard errors; `None` when no strength has one.
    #[must_use]
    pub fn significance(&self) -> Option<f64> {
        let strengths = self.parameters.iter().filter(|p| p.is_strength);
        let ratios = strengths.map(|p| p.value.abs() / p.standard_error);
        ratios.filter(|ratio| ratio.is_finite()).reduce(f64::max)
    }
}

/// A fitted parameter of an effect.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Estimate {
    /// Name in the patched model.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value, in that unit.
    pub value: f64,
    /// Standard error in the same unit, with everything else unknown as well.
    pub standard_error: f64,
    /// Whether it is a strength.
    pub is_strength: bool,
    /// Whether `1/value` is what a person would call it: a limit that is infinite at zero strength.
    pub is_reciprocal: bool,
}

/// A model with all values settled, and what it makes of the training logs.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Explanation {
    /// The model, patched where there is an effect; running it from the `starts` gives `outputs` to
    /// the bit; not serialised.
    #[serde(skip)]
    pub model: Model,
    /// Refitted parameters of the nominal model.
    pub nuisances: Vec<Nuisance>,
    /// Where runs start; not serialised.
    #[serde(skip)]
    pub starts: Vec<Start>,
    /// Simulated outputs of each log, row by row; not serialised.
    #[serde(skip)]
    pub outputs: Vec<Vec<f64>>,
    /// Root mean square of the training residual of each output, in sigma.
    pub gap: Vec<f64>,
}

/// A refitted parameter of the nominal model.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Nuisance {
    /// Name in the model.
    pub name: String,
    /// Value, in the unit of the parameter.
    pub value: f64,
    /// How far that is from nominal, in standard deviations of the prior.
    pub deviation: f64,
}

/// The start of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Place of the log among the training logs, from 0.
    pub log: usize,
    /// First sample.
    pub from: usize,
    /// State there, in the order of the states of the model.
    pub state: Vec<f64>,
}

/// A candidate without a fit: it could not be tried, or others promise far more.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct NotTested {
    /// Label of the effect.
    pub label: &'static str,
    /// The law.
    pub law: &'static str,
    /// Where it would be.
    pub site: SiteRef,
    /// Why it has no fit.
    pub reason: String,
}

impl NotTested {
    pub(super) fn of(candidate: &Candidate, reason: String) -> Self {
        let Candidate { label, law, site, .. } = candidate;
        Self { label, law, site: site.clone(), reason }
    }
}

impl From<&NotTestable> for NotTested {
    fn from(refusal: &NotTestable) -> Self {
        let NotTestable { label, law, site, reason } = refusal;
        Self { label, law, site: site.clone(), reason: reason.to_string() }
    }
}
