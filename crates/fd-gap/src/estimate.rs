//! Calibration: all uncertain parameters of a model from logs, and what the logs say of each.
//!
//! The fit is that of a diagnosis without any cause ([`null_fit`](crate::fit::null_fit)): weighted least squares over the
//! uncertain parameters and the unknown starts, each parameter with the Gaussian that its tolerance is. Around the
//! minimum the posterior is a Gaussian with the inverse of the normal equations as covariance `C`, in units of what was
//! known before (Bard 1974, *Nonlinear Parameter Estimation*, chapter 7). The eigenvectors of `C` are combinations of
//! parameters that are known independently of each other; a combination whose standard deviation the logs have not
//! halved is said to be open, and a parameter that is open by itself belongs to it.
//!
//! *When not to use:* where the model lacks something, the parameters are drawn towards what stands in for it. Standard
//! errors are then as much larger as the residual is than the noise, and still say nothing about the bias; the report
//! says what is left, and a diagnosis looks for its cause. Slow disturbances are taken for white noise here.

use faer::Mat;
use fd_numeric::dense::Dense;
use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    diagnose::{Case, prepare},
    fit::{FitError, Horizon, Minimum, NullFit, Problem, Variable},
    shrink::gap_per_output,
};

/// A combination is open where its standard deviation is more than this share of what it was before.
const OPEN: f64 = 0.5;
/// Share of a combination, of the sum of squares, from which a parameter is named with it.
const NAMED: f64 = 0.05;
/// Correlation from which errors of two parameters hang together.
const TOGETHER: f64 = 0.1;
/// Distance from the edge of a box, in standard deviations of the prior, within which a value is at it.
const EDGE: f64 = 1e-6;

/// What the logs say of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// They fix it.
    Found,
    /// They fix it only together with others.
    InCombination,
    /// They say next to nothing of it: the value is what was stated.
    Unmoved,
    /// It would go further than its tolerance or its bounds allow.
    AtEdge,
}

/// A parameter after the fit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Calibrated {
    /// Name in the model.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// What the model says.
    pub nominal: f64,
    /// What fits best.
    pub value: f64,
    /// How far that is from what the model says, in tolerances.
    pub tolerances: f64,
    /// Standard error, in the unit, with everything else unknown as well.
    pub standard_error: f64,
    /// That in parts of what was known before.
    pub of_prior: f64,
    /// What the logs say of it.
    pub standing: Standing,
}

/// Parameters that the logs fix only together, or not at all.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Combination {
    /// The parameters with their parts of the direction, in tolerances, the largest first.
    pub parts: Vec<(String, f64)>,
    /// Standard deviation along it, in parts of what it was before.
    pub of_prior: f64,
}

/// An output before and after.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Fitted {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Noise: stated, else as the logs show it.
    pub noise: f64,
    /// Root mean square of the residual with the values of the model.
    pub before: f64,
    /// With the calibrated ones.
    pub after: f64,
}

/// The parameters of a model, calibrated.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Calibration {
    /// The uncertain parameters, in the order of the model.
    pub parameters: Vec<Calibrated>,
    /// Correlations of their errors, row by row.
    pub correlations: Vec<Vec<f64>>,
    /// What is open.
    pub open: Vec<Combination>,
    /// The outputs.
    pub outputs: Vec<Fitted>,
    /// Measured values that were compared.
    pub measured: usize,
}

impl Calibration {
    /// The largest residual that is left, in units of the noise.
    #[must_use]
    pub fn left(&self) -> f64 {
        self.outputs.iter().map(|output| output.after / output.noise).fold(0.0, f64::max)
    }
}

/// Calibrates the uncertain parameters of a case on its logs.
///
/// # Errors
///
/// Returns an error when the logs do not fit the simulator or are too short, or the simulation diverges at the stated
/// parameters.
pub fn estimate(case: &Case<'_>, horizon: Horizon) -> Result<Calibration, FitError> {
    let NullFit { problem, minimum } = prepare(case, horizon)?.null;
    let mut problem = problem;
    let sigma = problem.weights().sigma.clone();
    let of = |errors: Option<Vec<Vec<Vec<f64>>>>| errors.map(|errors| gap_per_output(&errors));
    let origin = vec![0.0; minimum.z.len()];
    let before = of(problem.errors(&origin)).ok_or(FitError::Diverged)?;
    let after = of(problem.errors(&minimum.z)).ok_or(FitError::Diverged)?;
    // Errors of a model that lacks something are no noise, but the only measure of what they hide.
    let scale = after.iter().copied().fold(1.0, f64::max);
    let Found { parameters, covariance, open } =
        found(&problem, &minimum, scale).ok_or(FitError::Diverged)?;
    let deviation = |i: usize| covariance[(i, i)].sqrt();
    let n = parameters.len();
    let correlations = (0..n).map(|i| {
        let with = |j: usize| covariance[(i, j)] / (deviation(i) * deviation(j));
        (0..n).map(with).collect()
    });
    let outputs = case.nominal.model().outputs.iter().enumerate().map(|(c, output)| Fitted {
        name: output.name.clone(),
        unit: output.unit.clone(),
        noise: sigma[c],
        before: before[c] * sigma[c],
        after: after[c] * sigma[c],
    });
    Ok(Calibration {
        parameters,
        correlations: correlations.collect(),
        outputs: outputs.collect(),
        measured: problem.plan().measured(),
        open,
    })
}

/// What a fit says of the uncertain parameters.
struct Found {
    parameters: Vec<Calibrated>,
    covariance: Mat<f64>,
    open: Vec<Combination>,
}

/// The uncertain parameters of the nominal model after a fit, with all else unknown as well and noise that is `scale` times as
/// large as the weights say; none where the normal equations are singular.
pub(crate) fn parameters(problem: &Problem, minimum: &Minimum, scale: f64) -> Vec<Calibrated> {
    found(problem, minimum, scale).map_or_else(Vec::new, |found| found.parameters)
}

fn found(problem: &Problem, minimum: &Minimum, scale: f64) -> Option<Found> {
    let shared = problem.plan().nuisances();
    let covariance = problem.covariance(minimum, scale)?;
    let open = open(&covariance, &shared.iter().map(|v| v.name.as_str()).collect::<Vec<_>>());
    let is_combined =
        |name: &str| open.iter().any(|c| c.parts.len() > 1 && c.parts.iter().any(|p| p.0 == name));
    let calibrated = |(i, variable): (usize, &Variable)| {
        let (value, of_prior) = (variable.value(minimum.z[i]), covariance[(i, i)].sqrt());
        let edge = EDGE * variable.scale;
        let standing = if value <= variable.low + edge || variable.high - edge <= value {
            Standing::AtEdge
        } else if of_prior <= OPEN {
            Standing::Found
        } else if is_combined(&variable.name) {
            Standing::InCombination
        } else {
            Standing::Unmoved
        };
        Calibrated {
            name: variable.name.clone(),
            unit: variable.unit.clone(),
            nominal: variable.start,
            value,
            tolerances: variable.in_tolerances(value),
            standard_error: variable.scale * of_prior,
            of_prior,
            standing,
        }
    };
    let parameters = shared.iter().enumerate().map(calibrated).collect();
    Some(Found { parameters, covariance, open })
}

/// Combinations that the logs have not fixed, group by group of parameters whose errors hang together: between groups
/// directions would be mixed at will where they are equally open.
fn open(covariance: &Mat<f64>, names: &[&str]) -> Vec<Combination> {
    let mut open = Vec::new();
    for group in groups(covariance) {
        let n = group.len();
        let part = Mat::from_fn(n, n, |i, j| covariance[(group[i], group[j])]);
        let Ok(eigen) = part.symmetric_eigen() else { continue };
        let (values, vectors) = (eigen.S().column_vector(), eigen.U());
        for k in (0..n).rev() {
            let of_prior = values[k].max(0.0).sqrt();
            if of_prior <= OPEN {
                continue;
            }
            let part = |i: usize| (names[group[i]].to_owned(), vectors[(i, k)]);
            let mut parts: Vec<(String, f64)> = (0..n).map(part).collect();
            parts.retain(|(_, part)| NAMED < part * part);
            parts.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            open.push(Combination { parts, of_prior });
        }
    }
    open
}

/// Parameters in groups, each correlated with another of its group.
fn groups(covariance: &Mat<f64>) -> Vec<Vec<usize>> {
    let correlation =
        |i: usize, j: usize| covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for i in 0..covariance.nrows() {
        let hangs = |group: &Vec<usize>| group.iter().any(|j| TOGETHER < correlation(i, *j).abs());
        let (with, without): (Vec<_>, Vec<_>) = groups.into_iter().partition(hangs);
        groups = without;
        groups.push(with.into_iter().flatten().chain([i]).collect());
    }
    groups
}

#[cfg(test)]
mod tests {
    use faer::mat;

    use super::*;

    #[test]
    fn what_is_known_only_together_is_an_open_combination() {
        // The sum of the first two is known to 1 %, their difference not at all; the third is known, the fourth open.
        let (sum, difference) = (1e-4, 1.0);
        let (same, cross) = (0.5 * (sum + difference), 0.5 * (sum - difference));
        let covariance = mat![
            [same, cross, 0.0, 0.0],
            [cross, same, 0.0, 0.0],
            [0.0, 0.0, 0.01, 0.0],
            [0.0, 0.0, 0.0, 0.9]
        ];
        let open = open(&covariance, &["m", "k", "d", "g"]);
        let mut names: Vec<Vec<&str>> =
            open.iter().map(|c| c.parts.iter().map(|part| part.0.as_str()).collect()).collect();
        for group in &mut names {
            group.sort_unstable();
        }
        names.sort_unstable();
        assert_eq!(names, [vec!["g"], vec!["k", "m"]]);
        let open: Vec<_> = open.into_iter().filter(|c| c.parts.len() > 1).collect();
        assert!((open[0].of_prior - 1.0).abs() < 1e-12);
        assert!(open[0].parts[0].1 * open[0].parts[1].1 < 0.0, "they make up for each other");
    }
}
