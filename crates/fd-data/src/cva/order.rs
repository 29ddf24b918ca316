//! How many canonical variates are states.

use faer::MatRef;
use fd_numeric::dense::Dense;

use crate::error::DataError;

/// The rule for the number of states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum States {
    /// So many.
    Count(usize),
    /// The number with the least criterion of Akaike for the prediction of the next output, with Hurvich and
    /// Tsai's correction for small samples (Larimore 1990, eq. 3 to 5).
    #[default]
    Aic,
}

/// What the criterion looks at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prediction<'a> {
    /// Covariance of the next output.
    pub output: MatRef<'a, f64>,
    /// Covariance of the canonical variates (rows) with it; they have unit variance each.
    pub shared: MatRef<'a, f64>,
    /// Windows, inputs.
    pub samples: usize,
    pub inputs: usize,
}

impl States {
    /// The number; 1 to `most`.
    pub(super) fn count(self, of: &Prediction<'_>, most: usize) -> Result<usize, DataError> {
        match self {
            Self::Count(count) if 0 < count && count <= most => Ok(count),
            Self::Count(count) => Err(DataError::Setting {
                setting: "states",
                expected: format!("1 to {most}"),
                found: count as f64,
            }),
            Self::Aic => Ok(of.aic(most)),
        }
    }
}

impl Prediction<'_> {
    fn aic(&self, most: usize) -> usize {
        let (n, p, m) = (self.samples as f64, self.output.nrows() as f64, self.inputs as f64);
        let mut left = self.output.to_owned();
        let mut best = (f64::INFINITY, 1);
        for states in 1..=most {
            // Variates are uncorrelated, so each takes away its own share of what is to be predicted.
            let row = self.shared.row(states - 1);
            for j in 0..left.ncols() {
                for i in 0..left.nrows() {
                    left[(i, j)] -= row[i] * row[j];
                }
            }
            let Some(size) = log_determinant(left.as_ref()) else { break };
            let k = states as f64;
            let parameters = k * (2.0 * p + m) + m * p + p * (p + 1.0) / 2.0;
            let freedom = n - parameters / p - 0.5 * (p + 1.0);
            if freedom <= 0.0 {
                break;
            }
            let criterion = n * size + 2.0 * parameters * n / freedom;
            if criterion < best.0 {
                best = (criterion, states);
            }
        }
        best.1
    }
}

/// `ln det`, none where rounding leaves nothing positive.
fn log_determinant(matrix: MatRef<'_, f64>) -> Option<f64> {
    let factor = matrix.cholesky().ok()?;
    let l = factor.L();
    Some((0..l.nrows()).map(|i| 2.0 * l[(i, i)].ln()).sum())
}
