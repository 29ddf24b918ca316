//! What an effect offers to a diagnosis: candidates, each a patched model with parameters to fit.

use fd_sim::scales::ReplayScales;
use fd_sim::{equation::SyntaxError, model::Model, patch::PatchError};
use thiserror::Error;

use super::site::{Side, SiteRef};

/// What an effect offers: one candidate per law and site, or the reason why there is none.
pub type Offers = Vec<Result<Candidate, NotTestable>>;

/// A cause of a gap between simulator and reality, tried at every site where it makes sense.
///
/// An effect is physical knowledge: what friction does, how a valve sticks, in which ways a sensor can be
/// wrong. It does not depend on a particular plant. Given a model, it says where it could act, adds itself to a
/// copy of the model, and names the parameters to be fitted: a [`Candidate`]. Everything after that (screening,
/// fits, evidence, ties, words) works on candidates alone, so an added effect is diagnosed like all others.
///
/// # The contract
///
/// [`candidates`](Self::candidates) returns one entry per law and site: a candidate, or [`NotTestable`] with
/// the reason. Give a reason rather than omitting the entry; the report lists it, and "not found" must not look
/// like "not looked for". Each candidate obeys these rules, which the tests of this crate check for every entry
/// of [`library`](super::library) on every test plant:
///
/// * *Exactly nothing at zero strength.* With all strengths at their neutral values a simulation of
///   [`Candidate::model`] equals that of the nominal model, whatever the shape parameters are. The evidence for
///   an effect is the evidence for a strength that is not neutral; this rule makes "present" and "absent"
///   comparable.
/// * *Parameters in physical units*, with bounds that enforce the physical sign: friction dissipates energy, so
///   its coefficient is not negative. `scale` is chosen so that one unit of a fit is a noticeable change in
///   this log; take it from [`ReplayScales`], never from the nominal values alone.
/// * *Starts within the bounds.* Where the sum of squares may have several minima (a delay, a frequency, a
///   threshold), give several starts; where it has one, give one.
/// * *The same in other units*: a plant in mm has the same candidates, scaled.
/// * *The same integration grid* as the nominal model. An effect with a fast mode of its own uses the exact
///   solution over a step for held inputs, as those of the library do.
/// * *Its declared properties*: negative strengths only with [`is_signed`](Self::is_signed), and what
///   [`dissipates`](Self::dissipates) and [`has_slope`](Self::has_slope) promise.
/// * The [`label`](Self::label) is one cause. Its laws are variants that a diagnosis may choose among
///   without calling them different, the simplest one first.
///   The [`family`](Self::family) is the mechanism, wider than the label: what competes with what.
///
/// # Who calls it, and when
///
/// [`EverySite`](super::EverySite) calls `candidates` once with the nominal model, and again with each model
/// that contains one of the best answers, to look for pairs. It is not called per sample, so it may be slow and
/// may allocate. The same model and scales must give the same list: identities are compared between the two
/// calls.
///
/// # What an implementor must not do
///
/// * *Use measurements.* An effect sees the model and the sizes of its signals, not the log; whether it
///   explains anything is for the diagnosis to decide.
/// * *Panic on a strange model*: no inputs, one state, a site without a velocity. That is a `NotTestable`.
/// * *Add parameters that cannot be told apart.* If the outputs depend only on the product of two numbers,
///   every fit wanders.
///
/// # How it composes
///
/// List it in the `all()` of its side, such as [`dynamics::all`](super::dynamics::all), or hand a `Vec<Box<dyn Effect>>` of your own to
/// [`EverySite`](super::EverySite). Labels work on the command line from then on (`--exclude`, `--only`).
///
/// # When not to implement it
///
/// For a wrong value of a parameter that the model has: `parameter-error` is in the library, for each of them.
/// For a static curve of unknown shape at an input, force or sensor: the maps ([`map`](super::map)) find one
/// without a name. For a known property of the plant: put it into the model.
///
/// # Example
///
/// [`Sketch`](super::Sketch) does the bookkeeping: names, units, bounds and the patch. A pump whose flow varies
/// with the daily temperature:
///
/// ```
/// use fd_effect::{Candidate, Effect, NotTestable, Sketch};
/// use fd_sim::{scales::ReplayScales, model::Model};
///
/// #[derive(Debug)]
/// struct DailySwing;
///
/// impl Effect for DailySwing {
///     fn label(&self) -> &'static str {
///         "daily-swing"
///     }
///
///     fn family(&self) -> &'static str {
///         "actuator-gain"
///     }
///
///     fn candidates(
///         &self,
///         nominal: &Model,
///         scales: &ReplayScales,
///     ) -> Vec<Result<Candidate, NotTestable>> {
///         let each = scales.inputs.iter().enumerate().map(|(i, _)| {
///             Sketch::of_input(self, "sinusoid", nominal, scales, i)
///                 .strength("a", "swing", "1", 1.0, [0.0, 0.5])
///                 .wrap_input("u*(1 + a*sin(2*pi*t/86400))")
///                 .start(&[0.05])
///                 .finish()
///         });
///         each.collect()
///     }
/// }
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "tank"
/// sample_time = 60.0
/// inputs = { flow = { unit = "m^3/s" } }
/// states = { h = { unit = "m", initial = 1.0, derivative = "flow - 1e-4*h" } }
/// outputs = { level = { unit = "m", value = "h" } }
/// "#.parse()?;
/// let u: Vec<f64> = (0..500).map(|k| if k % 100 < 50 { 1e-4 } else { 2e-4 }).collect();
/// let scales = ReplayScales::of(&model, model.sample_time()?, &u, 500)?;
/// let candidates = DailySwing.candidates(&model, &scales);
/// let candidate = candidates[0].as_ref().unwrap();
/// assert_eq!(candidate.parameters[0].name, "flow_swing");
/// let applied = candidate.model.definitions.last().unwrap();
/// assert_eq!(applied.value.to_string(), "flow*(1 + flow_swing*sin(2*pi*t/86400))");
/// // Neutral, and so absent, until a fit finds otherwise.
/// assert!(candidate.parameters[0].is_strength && candidate.parameters[0].neutral == 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Effect: std::fmt::Debug + Send + Sync {
    /// Name of the effect, such as `coulomb-friction`: laws under one label are variants of one
    /// cause.
    fn label(&self) -> &'static str;

    /// The mechanism that the effect belongs to, such as `friction`: wider than the label.
    fn family(&self) -> &'static str;

    /// Whether strengths may be negative: a gain may be too small as well as too large. A negative width, delay
    /// or dry friction would have no meaning, so these start at 0.
    fn is_signed(&self) -> bool {
        false
    }

    /// Whether it dissipates energy of the motion at its site, from every start.
    fn dissipates(&self) -> bool {
        false
    }

    /// Whether the outputs respond to each strength at the first start, so that a fit can move away from it.
    /// False where they jump, or do not respond to some strengths.
    fn has_slope(&self) -> bool {
        true
    }

    /// Whether places of one kind are often made alike, so that its simplest law is tried at all of them together as well,
    /// with one strength.
    fn is_often_alike(&self) -> bool {
        false
    }

    /// One candidate per law and site, or the reason why there is none.
    fn candidates(
        &self,
        nominal: &Model,
        scales: &ReplayScales,
    ) -> Vec<Result<Candidate, NotTestable>>;
}

/// One law of an effect at one site.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Label of the effect, such as `coulomb-friction`.
    pub label: &'static str,
    /// The law, such as `symmetric`. The first law of a label at a site is the simplest. Parameters
    /// of the same name mean the same in all laws of a label, so that a fit of one starts another,
    /// the rest of its parameters being neutral.
    pub law: &'static str,
    /// The mechanism, wider than the label.
    pub family: &'static str,
    /// Where the effect is.
    pub site: SiteRef,
    /// The other end of a coupling. Label, law, site and partner together are unique.
    pub partner: Option<SiteRef>,
    /// Side of the plant.
    pub side: Side,
    /// What the effect acts on.
    pub kind: Kind,
    /// The model with the effect in it; with all strengths at their neutral values (which are the
    /// values in the model) its simulations equal those of the nominal model.
    pub model: Model,
    /// What there is to fit, in the order of the parameters at the end of those of the model.
    pub parameters: Vec<EffectParameter>,
    /// Points from which to fit, in physical units, in the order of `parameters`.
    pub starts: Vec<Vec<f64>>,
    /// A parameter, in Hz, that is better started at the peaks of the spectrum of the residual; the
    /// `starts` hold a coarse grid in its place.
    pub spectral: Option<usize>,
    /// The first parameter is the quantum that an input is rounded to, and its scale the largest
    /// input: outputs jump as it changes, so that it is searched before it is fitted. `starts` hold
    /// the coarse ones.
    pub rounding: Option<Rounding>,
}

impl Candidate {
    /// What its laws have in common: label, site and partner, as of a
    /// `fd_gap::diagnose::Cause`.
    #[must_use]
    pub fn identity(&self) -> (&'static str, &SiteRef, Option<&SiteRef>) {
        (self.label, &self.site, self.partner.as_ref())
    }
}

/// What an effect acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The simulation: the model is patched.
    Simulation,
    /// The measurement of an output, as a matter of its distribution: the model is the nominal one.
    Observation(Observation),
}

/// How a command becomes a multiple of a quantum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// To the nearest multiple.
    Nearest,
    /// The rest is cut off, as where a number is stored as an integer.
    TowardsZero,
    /// To the next multiple below, as of a counter.
    Downwards,
}

impl Rounding {
    /// The multiple of the quantum.
    ///
    /// ```
    /// use fd_effect::Rounding;
    ///
    /// assert_eq!(Rounding::Nearest.apply(-0.7, 0.5), -0.5);
    /// assert_eq!(Rounding::TowardsZero.apply(-0.9, 0.5), -0.5);
    /// assert_eq!(Rounding::Downwards.apply(-0.9, 0.5), -1.0);
    /// ```
    #[must_use]
    pub fn apply(self, u: f64, quantum: f64) -> f64 {
        let steps = u / quantum;
        quantum
            * match self {
                Self::Nearest => (steps + 0.5).floor(),
                Self::TowardsZero => steps.trunc(),
                Self::Downwards => steps.floor(),
            }
    }
}

/// What is wrong with the noise of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observation {
    /// A share of the samples is far off; `parameters` has the share.
    Outliers,
    /// The noise is stronger than stated; `parameters` has its standard deviation.
    Noise,
    /// The noise is stronger than stated and far from Gaussian; `parameters` has its standard
    /// deviation and the degrees of freedom of Student's distribution.
    HeavyTails,
    /// The clock jitters, so that the noise is the stronger the faster the output moves; `parameters` has the
    /// standard deviation of the clock.
    Jitter,
}

/// A parameter of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectParameter {
    /// Name in the patched model.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// One unit of the coordinate of a fit, in physical units.
    pub scale: f64,
    /// Lower bound in physical units.
    pub low: f64,
    /// Upper bound in physical units.
    pub high: f64,
    /// Where the effect is exactly absent (a strength) or has the simplest shape.
    pub neutral: f64,
    /// Whether the effect is absent at the neutral value, whatever the shape parameters are. With
    /// several strengths all of them must be neutral.
    pub is_strength: bool,
    /// Whether `1/value` is what a person would call it: a limit that is infinite at zero strength.
    pub is_reciprocal: bool,
    /// Whether it is one of the simulator itself: a linear stand-in does not know its kinks.
    pub is_native: bool,
    /// What becomes of it in another run of the plant.
    pub in_another_run: InAnotherRun,
}

/// What becomes of a parameter in another run of the plant, of which the clock begins anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InAnotherRun {
    /// It is the same: a property of the plant.
    #[default]
    Same,
    /// It is another one, as phase and size of a periodic force that nobody has synchronised with the log.
    Another,
    /// It goes on, from a time that nobody knows, as a drift does.
    GoesOn,
    /// It belongs to a path over time, which is another one in every run, and goes on in an unknown way after this one.
    Path,
}

/// Why a candidate cannot be tried.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{label} ({law}) cannot be tested here: {reason}")]
pub struct NotTestable {
    /// Label of the effect.
    pub label: &'static str,
    /// The law.
    pub law: &'static str,
    /// Where it would be.
    pub site: SiteRef,
    /// What is missing.
    pub reason: Box<Reason>,
}

/// What keeps an effect out of a model.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Reason {
    /// The site has no such quantity.
    #[error("the site has no {0}")]
    Missing(&'static str),
    /// A signal does not move, or a force does not move what is there.
    #[error("{0} does not move in this log")]
    Still(&'static str),
    /// There is nothing to couple to.
    #[error("there is no other {0}")]
    Alone(&'static str),
    /// The user says that the parameter is exact.
    #[error("the parameter is said to be exact")]
    Exact,
    /// The input is a column that parameters may follow.
    #[error("no equation uses the input")]
    Idle,
    /// The parameter is not used by the plant, or is zero.
    #[error("the plant does not depend on the parameter, or it is zero")]
    Unused,
    /// No starting point is within the bounds, for this log and integration step.
    #[error("the log is too short or the integration step too long for it")]
    Bounds,
    /// A template of the effect is not an expression.
    #[error("`{template}`: {error}")]
    Syntax {
        /// The template.
        template: String,
        /// What is wrong with it.
        error: SyntaxError,
    },
    /// The model cannot be patched.
    #[error(transparent)]
    Patch(#[from] PatchError),
}
