//! Where a running diagnosis begins.

use serde::{Deserialize, Serialize};

/// Where a running diagnosis begins, after each start and reset.
///
/// ```
/// use fdiag::spec::{PipelineSpec, StartSpec};
///
/// assert_eq!(PipelineSpec::default().start, StartSpec::Fitted);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StartSpec {
    /// With the bias that was fitted to the healthy logs: the switch is open.
    #[default]
    Fitted,
    /// In training: the bias is learned on line (eq. 18) from the first sample after the generator has
    /// settled, by the on-line way of `bias.learning` or else by recursive least squares, until
    /// `compensation.convergence` opens the switch. Thresholds come from the samples of the healthy logs
    /// after the switch opened in them.
    Training,
}
