//! Does the bias model pay? Channel by channel, on healthy samples that it has not learned from.

use fd_compensate::calibrate::autocorrelation_time;
use fd_numeric::rms;
use serde::{Deserialize, Serialize};

use super::fault_free::FaultFree;
use crate::spec::ApplySpec;

/// What the bias model is worth in one residual channel, in the units of the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Payment {
    /// Root mean square of the primary residual on held-out healthy samples.
    pub rms_primary: f64,
    /// The same less a constant, the mean of the residual that the bias was learned from.
    pub rms_constant: f64,
    /// The same of the residual less the bias model.
    pub rms_compensated: f64,
    /// By how much the bias model makes the mean square smaller than the better of the other two.
    pub gain: f64,
    /// Standard error of that, for samples that are correlated as these are.
    pub standard_error: f64,
    /// What is subtracted in this channel.
    pub applied: Applied,
    /// Why it is not the bias model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why_not: Option<WhyNot>,
}

/// What is subtracted from a residual channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Applied {
    /// The bias model.
    Bias,
    /// The mean of the residual that the bias was learned from: what the model says of the inputs adds nothing to it.
    Constant,
    /// Nothing.
    Nothing,
}

/// Why a bias model does not pay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum WhyNot {
    /// The spec says `bias.apply = "never"`.
    Never,
    /// No input moved while the bias was learned.
    Unexcited,
    /// The residual is noise: there is no bias.
    NoBias,
    /// The held-out samples are too few against their own memory to tell.
    TooShort,
    /// There is a bias, and it is not what this model says of the inputs.
    Nonlinear,
}

impl WhyNot {
    /// The reason, and what would help, as the end of a sentence.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Never => "the spec says bias.apply = \"never\"",
            Self::Unexcited => {
                "no input moves where the bias was learned: give healthy logs in which the inputs move"
            }
            Self::NoBias => "the residual is noise, without a bias that follows the inputs",
            Self::TooShort => {
                "the healthy samples that are kept back are too few against their own memory to tell: give longer \
                 or more healthy logs (--healthy), or a smaller --learn-share"
            }
            Self::Nonlinear => {
                "the residual does not follow the inputs as the bias model says: try bias.structure \"hammerstein\" or \
                 \"scheduled\" or bias.orders of kind \"choose\", or name the effect with `fdiag gap`"
            }
        }
    }
}

/// Standard errors that the gain must exceed.
const ERRORS: f64 = 1.0;
/// Largest memory of a residual that is noise, in samples: one of a moving average over two samples is 2.
const NOISE: f64 = 2.0;

/// What a payment is judged by beside the held-out samples.
pub(super) struct Terms<'a> {
    /// Whether an input moved.
    pub moves: bool,
    /// Means of the residuals that it was learned from.
    pub means: &'a [f64],
    pub apply: ApplySpec,
}

/// The payments of all channels.
pub(super) fn payments(held_out: &FaultFree, terms: &Terms<'_>) -> Vec<Payment> {
    let channels = terms.means.len();
    let channel = |values: &[f64], at: usize| -> Vec<f64> {
        values.iter().skip(at).step_by(channels).copied().collect()
    };
    let payment = |(at, mean): (usize, &f64)| {
        let primary = channel(&held_out.primary, at);
        let compensated = channel(&held_out.compensated, at);
        Payment::of(&primary, &compensated, *mean, terms)
    };
    terms.means.iter().enumerate().map(payment).collect()
}

/// By how much a mean square became smaller.
struct Gain {
    mean: f64,
    standard_error: f64,
    /// Whether the samples are enough against their own memory.
    is_known: bool,
}

impl Gain {
    fn of(before: &[f64], after: &[f64]) -> Self {
        let n = before.len() as f64;
        let gains: Vec<f64> = before.iter().zip(after).map(|(r, e)| r * r - e * e).collect();
        let mean = gains.iter().sum::<f64>() / n;
        let variance = gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / n;
        // What does not forget within half of the samples is worth two of them.
        let memory = autocorrelation_time(&gains);
        let standard_error = (variance * memory.unwrap_or(0.5 * n) / n).sqrt();
        Self { mean, standard_error, is_known: memory.is_some() }
    }

    fn pays(&self) -> bool {
        self.mean > ERRORS * self.standard_error
    }
}

impl Payment {
    fn of(primary: &[f64], compensated: &[f64], mean: f64, terms: &Terms<'_>) -> Self {
        let constant: Vec<f64> = primary.iter().map(|r| r - mean).collect();
        let of_constant = Gain::of(primary, &constant);
        let without = if 0.0 < of_constant.mean { &constant[..] } else { primary };
        let gain = Gain::of(without, compensated);
        let applied = match terms.apply {
            ApplySpec::Always => Applied::Bias,
            ApplySpec::WhereItPays if gain.pays() => Applied::Bias,
            ApplySpec::WhereItPays if of_constant.pays() => Applied::Constant,
            ApplySpec::Never | ApplySpec::WhereItPays => Applied::Nothing,
        };
        let is_noise = || autocorrelation_time(primary).is_some_and(|time| time <= NOISE);
        let why_not = (!gain.pays()).then(|| match () {
            () if terms.apply == ApplySpec::Never => WhyNot::Never,
            () if is_noise() => WhyNot::NoBias,
            () if !terms.moves => WhyNot::Unexcited,
            () if !gain.is_known && -gain.standard_error < gain.mean => WhyNot::TooShort,
            () => WhyNot::Nonlinear,
        });
        Self {
            rms_primary: rms(primary.iter().copied()),
            rms_constant: rms(constant),
            rms_compensated: rms(compensated.iter().copied()),
            gain: gain.mean,
            standard_error: gain.standard_error,
            applied,
            why_not,
        }
    }
}
