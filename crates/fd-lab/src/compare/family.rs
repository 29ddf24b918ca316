//! What kind of diagnosis an entry is, as the literature divides them.

use fdiag::spec::{DetectorSpec, GeneratorSpec};

use super::{config::CompareConfig, result::EntryName};

/// A way to be robust against a wrong model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Family {
    /// None: a residual of the wrong model and a constant threshold.
    ConstantThreshold,
    /// A threshold that follows the input.
    AdaptiveThreshold,
    /// A residual that an unknown input does not reach, or hardly.
    Decoupling,
    /// An observer that re-identifies the plant.
    AdaptiveObserver,
    /// A bias model.
    Compensation,
    /// A bias model behind a decoupled residual.
    CompensatedDecoupling,
    /// A bias model behind an adaptive observer.
    CompensatedAdaptation,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::ConstantThreshold,
        Self::AdaptiveThreshold,
        Self::Decoupling,
        Self::AdaptiveObserver,
        Self::Compensation,
        Self::CompensatedDecoupling,
        Self::CompensatedAdaptation,
    ];

    /// In a few words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ConstantThreshold => "constant threshold",
            Self::AdaptiveThreshold => "adaptive threshold",
            Self::Decoupling => "decoupling",
            Self::AdaptiveObserver => "adaptive observer",
            Self::Compensation => "compensation",
            Self::CompensatedDecoupling => "decoupling + compensation",
            Self::CompensatedAdaptation => "adaptive observer + compensation",
        }
    }

    /// That of an entry.
    fn of(generator: &GeneratorSpec, is_compensated: bool, detector: &DetectorSpec) -> Self {
        let follows = matches!(
            detector,
            DetectorSpec::AdaptiveThreshold(_) | DetectorSpec::ThresholdSelector(_)
        );
        match generator {
            GeneratorSpec::Adaptive { .. } if is_compensated => Self::CompensatedAdaptation,
            GeneratorSpec::Adaptive { .. } => Self::AdaptiveObserver,
            GeneratorSpec::UnknownInput { .. }
            | GeneratorSpec::Decoupled { .. }
            | GeneratorSpec::Eigenstructure { .. }
            | GeneratorSpec::Optimal { .. } => {
                if is_compensated {
                    Self::CompensatedDecoupling
                } else {
                    Self::Decoupling
                }
            }
            _ if is_compensated => Self::Compensation,
            _ if follows => Self::AdaptiveThreshold,
            _ => Self::ConstantThreshold,
        }
    }
}

impl CompareConfig {
    /// The family of an entry; `None` if there is no such entry.
    ///
    /// ```
    /// use fd_lab::compare::{CompareConfig, EntryName, Family};
    ///
    /// let [generator, bias, detector] = ["observer", "arx", "cusum"].map(str::to_owned);
    /// let entry = EntryName { generator, bias, detector };
    /// assert_eq!(CompareConfig::default().family(&entry), Some(Family::Compensation));
    /// ```
    #[must_use]
    pub fn family(&self, entry: &EntryName) -> Option<Family> {
        let generator = self.generators.iter().find(|g| g.name == entry.generator)?;
        let bias = self.biases.iter().find(|b| b.name == entry.bias)?;
        let detector = self.detectors.iter().find(|d| d.name == entry.detector)?;
        Some(Family::of(&generator.spec, bias.spec.is_some(), &detector.spec))
    }
}
