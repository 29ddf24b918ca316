//! How a recursive estimator forgets, and what keeps it from winding up, as plain data.

use fd_core::Scalar;
use serde::{Deserialize, Serialize};

use crate::error::IdentError;

/// How old samples lose their weight.
///
/// With information `R = P⁻¹` and regressor `φ`, per sample:
///
/// | kind | update | when not to use |
/// |---|---|---|
/// | `None` | `R⁺ = R + φφᵀ` | when the plant changes: the gain goes to zero, and in `f32` learning ends after 40 000 samples, see [`Guard`] |
/// | `Equation18` | `R⁺ = R + φφᵀ/α(k)` | with a constant `α` it does not forget, see below |
/// | `Exponential` | `R⁺ = λR + φφᵀ` | when excitation may stop: `P` grows as `λ⁻ᵏ` up to the guard, and the estimate wanders |
/// | `Directional` | `R⁺ = R + (λ − (1−λ)/φᵀPφ) φφᵀ` | when parameters drift in directions seldom excited |
/// | `Bounded` | `R⁺ = λR + φφᵀ + (1−λ)/c I` | when a bias-free covariance is needed: `P` is too small by the regularisation |
/// | `Resetting` | as `Exponential`, `P ← P₀` when `tr P` falls below a floor | when jumps of the gain, hence of the estimate, are not acceptable |
///
/// `Equation18` is eq. (18) of Patton & Chen (1992) as printed: `P(k)⁻¹ = P(k−1)⁻¹ +
/// φφᵀ/α(k)`, `K = Pφ/α(k)`. Sample `k` thus has the weight `1/α(k)`. With a constant `α` it is
/// ordinary least squares that starts from `P₀/α`: the paper calls `α` a forgetting factor, but
/// nothing is forgotten. What it says of the tracking speed, that it "can be improved by changing the
/// forgetting factor", holds for an `α(k)` that falls, [`Falling`]: as `α λᵏ` it gives the estimate of
/// `Exponential` to the digit, with `P` smaller by `α(k)`. No number can fall for ever, so `α` stops at
/// a least value, and then nothing more is forgotten. To forget for ever take `Exponential`, which is
/// the same with `P` counted anew in each sample.
///
/// `Directional` is Kulhavý (1987) in the form of Bittanti, Bolzern & Campi (1990): only what
/// the present regressor tells about anew is forgotten. `Bounded` adds the regularisation one
/// axis per sample in turn, so that a sample still costs O(n²), and leaves the estimate alone
/// (Levenberg-Marquardt regularisation, Ljung & Söderström 1983; Gay 1996); it keeps
/// `P ≤ λ^{1−n} c I` for any input, and forgets in excited directions as `Exponential` does.
///
/// When excitation stops, all kinds stay finite and bounded by [`Guard`], but only `Directional`
/// keeps the estimate: over a million samples of constant input it wandered 15 to 470 times less
/// than with `Exponential` (measured in the tests of this crate). Take it unless the plant is
/// known to be excited all the time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Forgetting<T = f64> {
    /// Every sample counts the same.
    #[default]
    None,
    /// The paper's eq. (18).
    Equation18 {
        /// `α > 0` of the first sample, the variance that the paper divides by.
        alpha: T,
        /// How `α(k)` falls from there; none keeps it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        falling: Option<Falling<T>>,
    },
    /// A sample of age `k` counts `λᵏ`.
    Exponential {
        /// Forgetting factor `0 < λ ≤ 1`.
        lambda: T,
    },
    /// Exponential, but only in the direction of the present regressor.
    Directional {
        /// Forgetting factor `0 < λ ≤ 1`.
        lambda: T,
    },
    /// Exponential with a covariance that cannot pass a bound.
    Bounded {
        /// Forgetting factor `0 < λ ≤ 1`.
        lambda: T,
        /// Largest variance `c > 0` of a parameter, relative to a noise of variance 1.
        variance: T,
    },
    /// Exponential, with the covariance reset when it has become small.
    Resetting {
        /// Forgetting factor `0 < λ ≤ 1`.
        lambda: T,
        /// Trace of `P`, as a part of its initial value, below which it is reset.
        floor: T,
    },
}

/// The course of `α(k)` in eq. (18): `α(k+1) = max(ratio α(k), least)`.
///
/// ```
/// use fd_ident::rls::{Falling, Forgetting, RlsDesign};
///
/// let falling = Falling { ratio: 0.99, least: 1e-3 };
/// assert!((falling.after(2.0_f64) - 1.98).abs() < 1e-15 && falling.after(1e-3) == 1e-3);
/// let design = RlsDesign::forgetting(Forgetting::Equation18 { alpha: 1.0, falling: Some(falling) });
/// # let _ = design;
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Falling<T = f64> {
    /// What a learned sample multiplies `α` by, above 0 and at most 1; skipped samples leave it alone.
    pub ratio: T,
    /// Where `α` stops: positive, at most its first value.
    pub least: T,
}

impl<T: Scalar> Falling<T> {
    /// `α` of the sample after one with `alpha`.
    #[must_use]
    pub fn after(&self, alpha: T) -> T {
        (self.ratio * alpha).max(self.least)
    }
}

/// Safeguards against wind-up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Guard {
    /// Skip samples whose `φᵀPφ` is below the rounding ε of the noise variance it adds to, so that
    /// nothing is forgotten in silence.
    ///
    /// Where nothing is forgotten (`None`, or with `λ = 1`) the bound is `ε^(2/3)`: each sample leaves a rounding of `ε ‖θ‖` in
    /// directions that may never be seen again, and after `N` samples one more lowers the variance of an estimate by
    /// `σ²/N²`, which is less from `N = σ/(ε ‖θ‖)` on. `ε^(2/3)` is that for a noise of `ε^(1/3)`, half a per cent of the
    /// parameters in `f32`: 40 000 samples there, 3e10 in `f64`.
    pub skip_silence: bool,
    /// Forgetting pauses while it would lift the trace of `P` above this many times its initial
    /// value.
    pub trace_limit: f64,
}

impl Default for Guard {
    fn default() -> Self {
        Self { skip_silence: true, trace_limit: 10.0 }
    }
}

impl Guard {
    /// No safeguards: for experiments on wind-up.
    ///
    /// ```
    /// # use fd_ident::rls::Guard;
    /// assert!(!Guard::off().skip_silence);
    /// ```
    #[must_use]
    pub const fn off() -> Self {
        Self { skip_silence: false, trace_limit: f64::INFINITY }
    }
}

/// Settings of a recursive estimator.
///
/// # Examples
///
/// ```
/// use fd_ident::rls::{Forgetting, RlsDesign};
///
/// let design = RlsDesign::forgetting(Forgetting::Exponential { lambda: 0.999 });
/// assert!(design.guard.skip_silence);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RlsDesign {
    /// Variance `c` of each parameter before the first sample, relative to a noise of variance
    /// 1: `P₀ = c I`, the same as a ridge of `1/c`. It depends on the units of the signals: for a
    /// regressor of size `s`, `c s²` times the number of samples should be large against 1.
    pub prior_variance: f64,
    /// How old samples lose their weight.
    pub forgetting: Forgetting,
    /// Safeguards against wind-up.
    pub guard: Guard,
}

impl Default for RlsDesign {
    fn default() -> Self {
        Self { prior_variance: 1e8, forgetting: Forgetting::None, guard: Guard::default() }
    }
}

impl RlsDesign {
    /// Default settings with another forgetting.
    #[must_use]
    pub fn forgetting(forgetting: Forgetting) -> Self {
        Self { forgetting, ..Self::default() }
    }

    /// Checks all settings.
    pub(crate) fn check(&self) -> Result<(), IdentError> {
        positive("prior variance", self.prior_variance)?;
        if self.guard.trace_limit.is_nan() || self.guard.trace_limit < 1.0 {
            let found = self.guard.trace_limit;
            return Err(IdentError::Setting {
                setting: "trace limit",
                expected: "at least 1",
                found,
            });
        }
        match self.forgetting {
            Forgetting::None => Ok(()),
            Forgetting::Equation18 { alpha, falling } => {
                positive("alpha of eq. (18)", alpha)?;
                let Some(Falling { ratio, least }) = falling else { return Ok(()) };
                let (setting, expected) = ("falling.ratio of eq. (18)", "above 0 and at most 1");
                in_range(setting, expected, 0.0 < ratio && ratio <= 1.0, ratio)?;
                let (setting, expected) = ("falling.least of eq. (18)", "positive, at most alpha");
                in_range(setting, expected, 0.0 < least && least <= alpha, least)
            }
            Forgetting::Exponential { lambda } | Forgetting::Directional { lambda } => {
                forgetting_factor(lambda)
            }
            Forgetting::Bounded { lambda, variance } => {
                forgetting_factor(lambda)?;
                positive("largest variance", variance)
            }
            Forgetting::Resetting { lambda, floor } => {
                forgetting_factor(lambda)?;
                let (setting, expected) = ("trace floor", "between 0 and 1");
                in_range(setting, expected, 0.0 < floor && floor < 1.0, floor)
            }
        }
    }
}

impl Guard {
    /// Samples with `φᵀPφ` of this, times the variance of the noise, or less are skipped.
    pub(crate) fn silence<T: Scalar>(&self, forgetting: &Forgetting) -> T {
        if !self.skip_silence {
            return -T::one();
        }
        let forgets = match *forgetting {
            Forgetting::None => false,
            Forgetting::Exponential { lambda } | Forgetting::Directional { lambda } => lambda < 1.0,
            // With an `α` that falls eq. (18) forgets as well.
            Forgetting::Equation18 { .. }
            | Forgetting::Bounded { .. }
            | Forgetting::Resetting { .. } => true,
        };
        let rounding = T::default_epsilon();
        if forgets { rounding } else { T::from_design(rounding.to_report().powf(2.0 / 3.0)) }
    }
}

impl Forgetting {
    /// Rounds the constants to the run-time scalar.
    pub(crate) fn freeze<T: Scalar>(self) -> Forgetting<T> {
        let t = T::from_design;
        match self {
            Self::None => Forgetting::None,
            Self::Equation18 { alpha, falling } => Forgetting::Equation18 {
                alpha: t(alpha),
                falling: falling
                    .map(|Falling { ratio, least }| Falling { ratio: t(ratio), least: t(least) }),
            },
            Self::Exponential { lambda } => Forgetting::Exponential { lambda: t(lambda) },
            Self::Directional { lambda } => Forgetting::Directional { lambda: t(lambda) },
            Self::Bounded { lambda, variance } => {
                Forgetting::Bounded { lambda: t(lambda), variance: t(variance) }
            }
            Self::Resetting { lambda, floor } => {
                Forgetting::Resetting { lambda: t(lambda), floor: t(floor) }
            }
        }
    }
}

fn forgetting_factor(lambda: f64) -> Result<(), IdentError> {
    let (setting, expected) = ("forgetting factor", "above 0 and at most 1");
    in_range(setting, expected, 0.0 < lambda && lambda <= 1.0, lambda)
}

pub(crate) fn positive(setting: &'static str, value: f64) -> Result<(), IdentError> {
    in_range(setting, "positive and finite", 0.0 < value && value.is_finite(), value)
}

fn in_range(
    setting: &'static str,
    expected: &'static str,
    inside: bool,
    found: f64,
) -> Result<(), IdentError> {
    if inside { Ok(()) } else { Err(IdentError::Setting { setting, expected, found }) }
}
