//! An unknown of a fit.

use fd_effect::{EffectParameter, InAnotherRun};
use fd_sim::{model::Parameter, simulate::Initial};

/// Standard deviation of what is known of a value, in tolerances.
const PRIOR: f64 = 0.67;
/// Half width of the box of a value, in tolerances.
const BOX: f64 = 2.0;

/// An unknown of a fit, with what is known of it. The fit itself works with
/// `z = (value − start)/scale`.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Name of the parameter or state.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Where the fit begins, and the mean of the prior.
    pub start: f64,
    /// A change that matters, in the unit.
    pub scale: f64,
    /// Lowest value.
    pub low: f64,
    /// Highest value.
    pub high: f64,
    /// Standard deviation of a Gaussian prior, in the unit; `None` for a flat one.
    pub prior: Option<f64>,
    /// Whether it is an effect of the simulator itself, of which no stand-in knows the slope far from rest.
    pub is_native: bool,
    /// What becomes of it in another run.
    pub in_another_run: InAnotherRun,
}

impl Variable {
    /// A value that is known up to a tolerance, in its unit: Gaussian of standard deviation
    /// 0.67 tolerances, within 2 tolerances.
    ///
    /// ```
    /// use fd_gap::fit::Variable;
    ///
    /// let mass = Variable::known("m", "kg", 2.0, 0.03);
    /// assert_eq!((mass.low, mass.high), (1.94, 2.06));
    /// ```
    #[must_use]
    pub fn known(name: &str, unit: &str, value: f64, tolerance: f64) -> Self {
        let (sd, half) = (PRIOR * tolerance, BOX * tolerance);
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            start: value,
            scale: sd,
            low: value - half,
            high: value + half,
            prior: Some(sd),
            is_native: false,
            in_another_run: InAnotherRun::Same,
        }
    }

    /// A parameter of an effect: free within its bounds, from where the effect is absent.
    #[must_use]
    pub fn effect(parameter: &EffectParameter) -> Self {
        let EffectParameter { name, unit, scale, low, high, neutral, .. } = parameter;
        Self {
            name: name.clone(),
            unit: unit.clone(),
            start: *neutral,
            scale: *scale,
            low: *low,
            high: *high,
            prior: None,
            is_native: parameter.is_native,
            in_another_run: parameter.in_another_run,
        }
    }

    /// A parameter as a nuisance, within its bounds; `None` when it is exact.
    #[must_use]
    pub fn nuisance(parameter: &Parameter) -> Option<Self> {
        let Parameter { name, unit, value, tolerance, bounds } = parameter;
        let tolerance = tolerance * value.abs();
        (0.0 < tolerance).then(|| {
            let mut variable = Self::known(name, unit, *value, tolerance);
            if let Some([low, high]) = bounds {
                variable.low = variable.low.max(*low).min(*value);
                variable.high = variable.high.min(*high).max(*value);
            }
            variable
        })
    }

    /// An initial state that is known up to its tolerance; `None` when it is exact.
    #[must_use]
    pub fn initial(state: &Initial) -> Option<Self> {
        let tolerance = state.tolerance.filter(|tolerance| 0.0 < *tolerance)?;
        Some(Self::known(&state.channel.name, &state.channel.unit, state.value, tolerance))
    }

    /// Whether it belongs to a path over time.
    pub(crate) fn is_path(&self) -> bool {
        self.in_another_run == InAnotherRun::Path
    }

    /// How far a value that is [`known`](Self::known) is from its start, in tolerances.
    pub(crate) fn in_tolerances(&self, value: f64) -> f64 {
        PRIOR * (value - self.start) / self.scale
    }

    /// The value in its unit.
    #[must_use]
    pub fn value(&self, z: f64) -> f64 {
        self.start + self.scale * z
    }

    /// The scaled value.
    #[must_use]
    pub fn scaled(&self, value: f64) -> f64 {
        (value - self.start) / self.scale
    }

    /// The box of the scaled value.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        [self.scaled(self.low), self.scaled(self.high)]
    }

    /// Precision (inverse variance) of the prior of the scaled value.
    #[must_use]
    pub fn precision(&self) -> f64 {
        self.prior.map_or(0.0, |sd| (self.scale / sd).powi(2))
    }
}
