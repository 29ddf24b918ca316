//! Which bias model, and how it is learned, as lines of a spec.

use fd_ident::{
    arx::ArxOrders,
    hammerstein::Basis,
    instrumental::{Instruments, IvDesign},
    order::Criterion,
    random_walk::RandomWalkDesign,
    rls::RlsDesign,
};
use serde::{Deserialize, Serialize};

/// The bias model `μ(k) + a₁ μ(k−1) + … = b₀ u(k) + …` and how it is learned.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BiasSpec {
    /// What kind of model it is.
    pub structure: StructureSpec,
    /// How many terms it has.
    pub orders: OrderSpec,
    /// How its parameters are found.
    pub learning: LearningSpec,
    /// Whether it is subtracted.
    pub apply: ApplySpec,
}

/// Whether a learned bias is subtracted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ApplySpec {
    /// In each residual channel in which it makes held-out healthy residuals smaller by more than the standard error.
    #[default]
    WhereItPays,
    /// In every channel.
    Always,
    /// In none: nothing is learned, and the primary residual is judged.
    Never,
}

fn paper_most() -> usize {
    3
}

/// Orders of the bias model: given, or chosen from the training data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum OrderSpec {
    /// Chosen together with everything else that the spec leaves open: orders up to `most`, delay and constant term;
    /// output error besides least squares, unless `learning` says another way; Hammerstein and scheduled structures
    /// besides the linear one, unless `structure` says another. Decided by free runs over healthy samples that the
    /// fit has not seen; the simplest form within one standard error of the best is taken.
    Choose {
        /// Highest order; the paper recommends less than 5.
        #[serde(default = "paper_most")]
        most: usize,
    },
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

impl Default for OrderSpec {
    fn default() -> Self {
        Self::Choose { most: paper_most() }
    }
}

/// What kind of model the bias is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum StructureSpec {
    /// One difference equation per residual channel, the paper's.
    #[default]
    Linear,
    /// A static nonlinearity on every input before the equations.
    Hammerstein {
        /// Which functions of the inputs.
        basis: Basis,
    },
    /// Local equations over the range of a slow input.
    Scheduled {
        /// Index of the input that tells the operating point.
        #[serde(default)]
        input: usize,
        /// Time constant in s by which it is slowed down.
        time_constant_s: f64,
        /// Number of regions, spread evenly over the training data.
        #[serde(default = "two_regions")]
        regions: usize,
        /// Centres of the regions in the (scaled) unit of the input, in place of `regions`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        centres: Option<Vec<f64>>,
    },
    /// One state-space model for all residual channels, by subspace identification; `orders`
    /// counts only for its constant term, and `learning` not at all.
    StateSpace {
        /// Number of states.
        states: usize,
        /// Samples of past and of future; none takes `2 states + 2`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        horizon: Option<usize>,
    },
}

/// Lines of specs, at least one of each structure, the default first.
#[cfg(feature = "testing")]
pub(super) const EVERY_STRUCTURE: [&str; 5] = [
    r#"kind = "linear""#,
    r#"kind = "hammerstein", basis = { kind = "polynomial", degree = 2 }"#,
    r#"kind = "hammerstein", basis = { kind = "piecewise-linear", segments = 3 }"#,
    r#"kind = "scheduled", time_constant_s = 4.0, regions = 2"#,
    r#"kind = "state-space", states = 3, horizon = 6"#,
];

fn two_regions() -> usize {
    2
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
    /// Instrumental variables: unbiased in measurement noise.
    Instrumental {
        /// What stands for the noisy past.
        #[serde(default)]
        instruments: Instruments,
    },
    /// Refined instrumental variables: of least variance in white measurement noise.
    RefinedInstrumental {},
    /// Iterated extended least squares, moving-average noise in the equation.
    Extended {
        /// Order of the noise.
        nc: usize,
    },
    /// Prediction error, moving-average noise in the equation.
    Armax {
        /// Order of the noise.
        nc: usize,
    },
    /// Prediction error, white measurement noise: the best fit of the simulation.
    OutputError {
        /// Whether every log begins at rest; otherwise its start is estimated.
        #[serde(default)]
        from_rest: bool,
    },
    /// Prediction error, coloured measurement noise `C/D`.
    BoxJenkins {
        /// Order of `C`.
        nc: usize,
        /// Order of `D`.
        nd: usize,
        /// Whether every log begins at rest; otherwise its start is estimated.
        #[serde(default)]
        from_rest: bool,
    },
    /// Recursive least squares in the running pipeline, until it converges (eq. 18).
    Recursive(RlsDesign),
    /// Recursive least squares as a Kalman filter of parameters that walk at random.
    RandomWalk(RandomWalkDesign),
    /// Recursive extended least squares.
    RecursiveExtended {
        /// Order of the noise.
        nc: usize,
        /// The estimator.
        #[serde(default)]
        rls: RlsDesign,
    },
    /// Recursive instrumental variables.
    RecursiveInstrumental(IvDesign),
}

/// Lines of specs, at least one of each way of learning, the default first.
#[cfg(feature = "testing")]
pub(super) const EVERY_LEARNING: [&str; 16] = [
    r#"kind = "batch""#,
    r#"kind = "batch", prefilter_rad_s = 4.0"#,
    r#"kind = "instrumental""#,
    r#"kind = "instrumental", instruments = { kind = "simulated", rounds = 2 }"#,
    r#"kind = "instrumental", instruments = { kind = "delayed-inputs" }"#,
    r#"kind = "instrumental", instruments = { kind = "delayed-outputs", lag = 2 }"#,
    r#"kind = "refined-instrumental""#,
    r#"kind = "extended", nc = 2"#,
    r#"kind = "armax", nc = 2"#,
    r#"kind = "output-error""#,
    r#"kind = "output-error", from_rest = true"#,
    r#"kind = "box-jenkins", nc = 1, nd = 1"#,
    r#"kind = "recursive", prior_variance = 1e6"#,
    r#"kind = "random-walk", prior_variance = 1e6, drift = { kind = "uniform", variance = 1e-9 }"#,
    r#"kind = "recursive-extended", nc = 2, rls = { prior_variance = 1e6 }"#,
    r#"kind = "recursive-instrumental", prior_variance = 1e6, warm_up = 300"#,
];

impl LearningSpec {
    /// Whether it learns in the running pipeline, sample by sample, from one log.
    #[must_use]
    pub fn is_on_line(&self) -> bool {
        matches!(
            self,
            Self::Recursive(_)
                | Self::RandomWalk(_)
                | Self::RecursiveExtended { .. }
                | Self::RecursiveInstrumental(_)
        )
    }
}

impl Default for LearningSpec {
    fn default() -> Self {
        Self::Batch { prefilter_rad_s: None }
    }
}
