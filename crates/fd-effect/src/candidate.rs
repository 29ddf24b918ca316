//! What an effect offers to a diagnosis: candidates, each a patched model with parameters to fit.

use fd_sim::scales::ReplayScales;
use fd_sim::{equation::SyntaxError, model::Model, patch::PatchError};
use thiserror::Error;

use super::site::{Side, SiteRef};

/// A cause of a gap between simulator and reality, tried at every site where it makes sense.
///
/// An effect is knowledge about the world: what friction does, how a valve sticks, in which ways a
/// sensor is wrong. It knows nothing of a particular plant. Given one, it says where it could be, writes
/// itself into a copy of the model, and names the numbers that would have to be found: a
/// [`Candidate`]. Everything after that (screening, fits, evidence, ties, words) works on candidates
/// alone, so an effect that is added is diagnosed like all others.
///
/// # The contract
///
/// [`candidates`](Self::candidates) returns one entry per law and site: a candidate, or
/// [`NotTestable`] with the reason. Say why rather than leave out; the report lists it, and "not found"
/// must not look like "not looked for". Each candidate obeys these laws, which the tests of this crate
/// check on every entry of [`library`](super::library), on every plant that they have:
///
/// * *Exactly nothing at zero strength.* With all strengths at their neutral values a simulation of
///   [`Candidate::model`] equals that of the nominal model, whatever the shape parameters are. The
///   evidence for an effect is the evidence for a strength that is not neutral, so this is what makes
///   "present" and "absent" comparable.
/// * *Parameters in physical units*, with the sign that physics gives them as bound: friction takes
///   energy out, so its coefficient is not negative. `scale` is the size that makes one unit of a fit a
///   noticeable change in this log; take it from [`ReplayScales`], never from the nominal values alone.
/// * *Starts within the bounds.* Where the sum of squares has several valleys (a delay, a frequency, a
///   threshold), give several; where it is a bowl, one.
/// * *The same in other units*: a plant in mm has the same candidates, scaled.
/// * *The same integration grid* as the nominal model. An effect with a fast mode of its own is written
///   exactly over a step for held inputs, as those of the library are.
/// * *What it says of itself*: strengths below zero only with [`is_signed`](Self::is_signed), and what
///   [`dissipates`](Self::dissipates) and [`has_slope`](Self::has_slope) promise.
/// * The [`label`](Self::label) is one cause. Its laws are variants that a diagnosis may choose among
///   without calling them different, the simplest one first.
///   The [`family`](Self::family) is the mechanism, wider than the label: what competes with what.
///
/// # Who calls it, and when
///
/// [`EverySite`](super::EverySite) calls `candidates` once with the nominal model, and again, beside each of
/// the best answers, with a model that has that one in it, to look for pairs. It is not called per sample,
/// and may take its time and allocate. The same model and scales must give the same list: identities
/// are compared between the two calls.
///
/// # What an implementor must not do
///
/// * *Look at measurements.* An effect sees the model and the sizes of its signals, not the log; whether it
///   explains anything is the diagnosis's question.
/// * *Panic on a strange model*: no inputs, one state, a site without a velocity. That is a `NotTestable`.
/// * *Add parameters that cannot be told apart.* Two numbers of which the outputs show only the product make
///   every fit wander.
///
/// # How it composes
///
/// List it in the `all()` of its side, such as [`dynamics::all`](super::dynamics::all), or hand a `Vec<Box<dyn Effect>>` of your own to
/// [`EverySite`](super::EverySite). Labels work on the command line from then on (`--exclude`, `--only`).
///
/// # When not to implement it
///
/// For a wrong value of a parameter that the model has: `parameter-error` is in the library, for each of
/// them. For a static curve of unknown shape at an input, force or sensor: the maps
/// ([`map`](super::map)) find one without a name. For something that belongs to the plant and is
/// known: put it into the model.
///
/// # Example
///
/// [`Sketch`](super::Sketch) does the bookkeeping: names, units, bounds and the patch. A pump that loses a
/// part of its flow with the temperature of the day:
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

    /// Whether strengths may be negative: a gain may be too small as well as too large. A width, a
    /// delay or a dry friction below zero would be something else, and starts at 0.
    fn is_signed(&self) -> bool {
        false
    }

    /// Whether it takes energy out of the motion of its site, from every start.
    fn dissipates(&self) -> bool {
        false
    }

    /// Whether the outputs follow each strength from the first start on, so that a fit can leave
    /// it. Not where they jump, or see nothing of some strengths.
    fn has_slope(&self) -> bool {
        true
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
    /// Values lie on a grid; `parameters` has its step.
    Quantised,
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
