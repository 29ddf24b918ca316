//! How a diagnosis is made.

use std::str::FromStr;

use schemars::JsonSchema;
use serde::Serialize;

use crate::fit::Horizon;

/// How a diagnosis is made; the defaults are for most logs.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How long a simulation runs without seeing the outputs.
    pub horizon: Horizon,
    /// Horizons at which the gap on held-out data is reported.
    pub report_horizons: Vec<Horizon>,
    /// Causes (effect and site) that are fitted to the end.
    pub finalists: usize,
    /// Causes that are fitted at all, those of which the scores promise most.
    pub shortlist: usize,
    /// Probability of "no gap" before the data.
    pub no_gap: f64,
    /// Probability before the data that a gap has a cause that is not among those tried.
    pub unknown: f64,
    /// Probability before the data that a gap has two causes.
    pub two: f64,
    /// What evidence is divided by.
    pub temperature: f64,
    /// Causes within this Bayes factor of the best are its rivals.
    pub bayes_factor: f64,
    /// Single causes that the probabilities before the data are shared among; `None` for those that are tried.
    pub causes: Option<usize>,
    /// Replicas of the bootstrap.
    pub replicas: usize,
    /// Seed of the bootstrap.
    pub seed: u64,
    /// Where logs may begin.
    pub beginning: Beginning,
    /// What the controller of a loop acts on.
    pub controller_sees: ControllerSees,
    /// What is left out, to see what it brings.
    pub without: Without,
}

/// Where logs may begin, as far as the model does not leave it open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Beginning {
    /// Where the model says, or in motion if their beginnings speak for that without any effect: what explains them
    /// better.
    #[default]
    Either,
    /// The same, whatever their beginnings say.
    Doubted,
    /// Where the model says.
    AsStated,
    /// In motion.
    InMotion,
}

/// What a controller that the model has, and that acts at samples of the log, acts on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ControllerSees {
    /// What was logged, or what is simulated: what leaves the smaller innovations without any effect.
    #[default]
    Either,
    /// What was logged, noise included: that of the real loop.
    Logged,
    /// What is simulated: the loop is closed in the simulator, which knows nothing of the noise.
    Simulated,
}

impl FromStr for ControllerSees {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "either" => Ok(Self::Either),
            "logged" => Ok(Self::Logged),
            "simulated" => Ok(Self::Simulated),
            _ => Err("expected `either`, `logged` or `simulated`".to_owned()),
        }
    }
}

/// Of the best, so many get another look: second causes are tried beside them, forecasts asked of them, other causes fitted from
/// where they are.
pub(crate) const LEADING: usize = 4;

/// Causes that are fitted to the end where only the best law is wanted.
const FINALISTS: usize = 3;
/// Causes that are fitted at all there.
const SHORTLIST: usize = 6;

impl Settings {
    /// What is needed to find the best law, and no more: two at a time would take as long as all the rest.
    pub(crate) fn for_one_law(&self) -> Self {
        Self { two: 0.0, finalists: FINALISTS, shortlist: SHORTLIST, ..self.clone() }
    }
}

/// Rules of a diagnosis that can be left out, to see what they bring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Without {
    /// That a log may begin in motion.
    pub free_starts: bool,
    /// That what an engineer would not believe at first sight is not named.
    pub vetoes: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            horizon: Horizon::FreeRun,
            report_horizons: vec![Horizon::FreeRun],
            finalists: 10,
            shortlist: usize::MAX,
            no_gap: 0.4,
            unknown: 0.1,
            two: 0.1,
            temperature: 1.5,
            bayes_factor: 20.0,
            causes: None,
            replicas: 400,
            seed: 1,
            beginning: Beginning::default(),
            controller_sees: ControllerSees::default(),
            without: Without::default(),
        }
    }
}
