//! A pipeline described as data: one TOML file chooses every stage.
//!
//! Each table has a `kind`; an unknown kind or setting is refused with the list of known ones.
//! A spec is a closed list of the methods that we ship. A method of your own goes straight into
//! [`Stages`](fd_core::Stages), boxed or not.

mod adaptive;
mod detector;
mod generator;
mod isolation;
mod signature;

use fd_compensate::{
    calibrate::CalibrationPlan,
    decide::{Debouncing, Sizing},
    residual_compensation::CompensationPlan,
};
use fd_ident::{arx::ArxOrders, order::Criterion, rls::RlsDesign};
use serde::{Deserialize, Serialize};

pub use self::{
    adaptive::{AdaptiveSpec, BoundSpec},
    detector::{DetectorData, DetectorSpec, DetectorSpecError},
    generator::{
        DisturbanceSpec, FaultEntry, GeneratorSpec, ParameterSpec, ShiftSpec, StructureSpec,
    },
    isolation::{IsolationSpec, IsolationSpecError},
    signature::FaultSites,
};

/// Every choice of a diagnosis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PipelineSpec {
    /// Samples to primary residuals.
    pub generator: GeneratorSpec,
    /// Rows of the weighting `W` on the residual; none leaves it as it is. The paper's choice for
    /// five outputs is `[[1, 1, 1, 1, 1]]`, which makes the residual a scalar.
    pub weighting: Option<Vec<Vec<f64>>>,
    /// The bias model and how it is learned.
    pub bias: BiasSpec,
    /// When training ends, and what guards the compensation.
    pub compensation: CompensationPlan,
    /// Compensated residuals to test statistics.
    pub detector: DetectorSpec,
    /// How a threshold is found for a stated rate of false alarms; its debouncing is that of
    /// `rule`.
    pub calibration: CalibrationPlan,
    /// Test statistics to alarms.
    pub rule: Debouncing,
    /// What is said of a fault beyond that there is one.
    pub isolation: IsolationSpec,
    /// How the size of a fault is estimated after an alarm, but for probable faults.
    pub sizing: Sizing,
    /// Time in s at the start of each log that is not learned from, while the generator forgets
    /// where it started; none takes five time constants of its slowest pole.
    pub settle_s: Option<f64>,
    /// Most missing samples in a row that are replaced by the last good one; 0 refuses them.
    pub hold_missing: u64,
}

impl Default for PipelineSpec {
    fn default() -> Self {
        Self {
            generator: GeneratorSpec::Simulation {},
            weighting: None,
            bias: BiasSpec::default(),
            compensation: CompensationPlan::default(),
            detector: DetectorSpec::default(),
            calibration: CalibrationPlan::default(),
            rule: Debouncing::consecutive(3),
            isolation: IsolationSpec::default(),
            sizing: Sizing::default(),
            settle_s: None,
            hold_missing: 0,
        }
    }
}

/// The bias model `μ(k) + a₁ μ(k−1) + … = b₀ u(k) + …` and how it is learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BiasSpec {
    /// How many terms it has.
    pub orders: OrderSpec,
    /// How its parameters are found.
    pub learning: LearningSpec,
}

impl Default for BiasSpec {
    fn default() -> Self {
        Self { orders: OrderSpec::Fixed(ArxOrders::paper(2)), learning: LearningSpec::default() }
    }
}

/// Orders of the bias model: given, or chosen from the training data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum OrderSpec {
    /// Given.
    Fixed(ArxOrders),
    /// Chosen by a criterion among the paper's structures of order 1 to `most`.
    Select {
        /// Highest order; the paper recommends less than 5.
        most: usize,
        /// What decides. `held-out` is the error of a simulation over the last part of the
        /// training data, which is then not used for the comparison.
        #[serde(default)]
        criterion: Criterion,
        /// Whether there is a constant term.
        #[serde(default)]
        offset: bool,
    },
}

/// How the parameters of the bias model are found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum LearningSpec {
    /// Least squares over all healthy logs together.
    Batch {
        /// Corner in rad/s of a second-order low-pass that input and residual both go
        /// through before the fit; it leaves their transfer function as it is and keeps noise out.
        /// None fits the raw signals, as the paper does.
        #[serde(default)]
        prefilter_rad_s: Option<f64>,
    },
    /// Recursive least squares in the running pipeline, until it converges (eq. 18).
    Recursive(RlsDesign),
}

impl Default for LearningSpec {
    fn default() -> Self {
        Self::Batch { prefilter_rad_s: None }
    }
}
