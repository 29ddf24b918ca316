//! Does the bias model pay? Channel by channel, on healthy samples that it has not learned from.

use fd_compensate::calibrate::autocorrelation_time;
use fd_numeric::rms;
use serde::{Deserialize, Serialize};

use super::fault_free::FaultFree;

/// What the bias model is worth in one residual channel, in the units of the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Payment {
    /// Root mean square of the primary residual on held-out healthy samples.
    pub rms_primary: f64,
    /// The same of the compensated residual.
    pub rms_compensated: f64,
    /// By how much the mean square became smaller.
    pub gain: f64,
    /// Standard error of that, for samples that are correlated as these are.
    pub standard_error: f64,
    /// Whether the bias is subtracted in this channel.
    pub applied: bool,
    /// Why it is not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why_not: Option<WhyNot>,
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
    /// The residual is a constant and noise, and the model has no constant term.
    ConstantOnly,
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
            Self::ConstantOnly => {
                "the residual is a constant and noise, and the bias model has no constant term: \
                 bias.orders with offset = true, or kind = \"choose\", removes it"
            }
            Self::NoBias => "the residual is noise, without a bias that could be learned",
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
/// Least share of a constant in the mean square of a residual that is a constant and noise.
const CONSTANT: f64 = 0.5;

/// What was learned and how.
pub(super) struct Learned {
    pub(super) moves: bool,
    pub(super) has_constant: bool,
    pub(super) never: bool,
}

/// The payments of all channels.
pub(super) fn payments(held_out: &FaultFree, channels: usize, learned: &Learned) -> Vec<Payment> {
    let channel = |values: &[f64], at: usize| -> Vec<f64> {
        values.iter().skip(at).step_by(channels).copied().collect()
    };
    (0..channels)
        .map(|at| {
            payment(&channel(&held_out.primary, at), &channel(&held_out.compensated, at), learned)
        })
        .collect()
}

fn payment(primary: &[f64], compensated: &[f64], learned: &Learned) -> Payment {
    let n = primary.len() as f64;
    let gains: Vec<f64> = primary.iter().zip(compensated).map(|(r, e)| r * r - e * e).collect();
    let gain = gains.iter().sum::<f64>() / n;
    let variance = gains.iter().map(|g| (g - gain).powi(2)).sum::<f64>() / n;
    // What does not forget within half of the samples is worth two of them.
    let memory = autocorrelation_time(&gains);
    let standard_error = (variance * memory.unwrap_or(0.5 * n) / n).sqrt();
    let applied = gain > ERRORS * standard_error && !learned.never;
    let why_not = (!applied).then(|| {
        let mean = primary.iter().sum::<f64>() / n;
        let square = primary.iter().map(|r| r * r).sum::<f64>() / n;
        let noise = autocorrelation_time(primary).is_some_and(|time| time <= NOISE);
        match () {
            () if learned.never => WhyNot::Never,
            () if mean * mean > CONSTANT * square && !learned.has_constant => WhyNot::ConstantOnly,
            () if noise => WhyNot::NoBias,
            () if !learned.moves => WhyNot::Unexcited,
            () if memory.is_none() => WhyNot::TooShort,
            () => WhyNot::Nonlinear,
        }
    });
    Payment {
        rms_primary: rms(primary.iter().copied()),
        rms_compensated: rms(compensated.iter().copied()),
        gain,
        standard_error,
        applied,
        why_not,
    }
}
