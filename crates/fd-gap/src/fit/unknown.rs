//! What nobody has written down, as a covariance of residuals.

use std::ops::Range;

use faer::{Mat, Side};
use fd_numeric::dot;

/// Variance of a direction, in that of the noise, below which nothing is seen of it: all that are left out together are
/// worth less than a nat.
const SEEN: f64 = 1e-3;

/// Residuals of unit noise that is in truth stronger, and to which unknown disturbances add: the covariance
/// `S (I + W Wᵀ) S` with the strength of the noise of each output in `S`.
///
/// The columns of `W` are the responses of all residuals to independent disturbances of unit variance; each responds
/// within one segment. With `W = U Λ^½ Vᵀ`, `(I + W Wᵀ)^−½ = I − U (I − (I + Λ)^−½) Uᵀ` and its determinant is `Π (1 + λ)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    noise: Vec<f64>,
    /// Per segment.
    blocks: Vec<Vec<Direction>>,
}

/// A direction in which disturbances move the residuals of a segment.
#[derive(Clone, Debug, PartialEq)]
struct Direction {
    /// Of unit length.
    along: Vec<f64>,
    /// `(1 + λ)^−½`.
    shrink: f64,
}

impl Unknown {
    /// Of the strength of the noise of each output, and responses, column by column, of the residuals of these segments
    /// (output by output) in units of it; `None` when an eigenvalue does not converge.
    ///
    /// ```
    /// use fd_gap::fit::Unknown;
    ///
    /// // A constant of standard deviation two beside three samples of unit noise.
    /// let unknown = Unknown::new(vec![1.0], &[vec![2.0; 3]], &[0..3]).ok_or("no eigenvalues")?;
    /// let mut r = vec![1.0, 2.0, 3.0];
    /// unknown.whiten(0, &mut r);
    /// // The mean shrinks by √(1 + 3 · 2²), the differences stay.
    /// let mean = 2.0 / 13.0_f64.sqrt();
    /// assert!((r[0] - (mean - 1.0)).abs() < 1e-12 && (r[1] - mean).abs() < 1e-12);
    /// assert!((unknown.log_determinant(&[3.0]) - 13.0_f64.ln()).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new(noise: Vec<f64>, columns: &[Vec<f64>], segments: &[Range<usize>]) -> Option<Self> {
        let blocks = segments.iter().map(|rows| directions(columns, rows.clone()));
        let blocks = blocks.collect::<Option<_>>()?;
        Some(Self { noise, blocks })
    }

    /// `C^−½ r` of a segment.
    pub fn whiten(&self, segment: usize, r: &mut [f64]) {
        self.scale(r, f64::recip);
        self.stretch(segment, r, |shrink| shrink);
    }

    /// `C^½ r`, the inverse of [`whiten`](Self::whiten).
    pub fn restore(&self, segment: usize, r: &mut [f64]) {
        self.stretch(segment, r, f64::recip);
        self.scale(r, |noise| noise);
    }

    fn scale(&self, r: &mut [f64], factor: impl Fn(f64) -> f64) {
        let length = r.len() / self.noise.len().max(1);
        for (rows, noise) in r.chunks_mut(length.max(1)).zip(&self.noise) {
            for r in rows {
                *r *= factor(*noise);
            }
        }
    }

    fn stretch(&self, segment: usize, r: &mut [f64], factor: impl Fn(f64) -> f64) {
        for Direction { along, shrink } in &self.blocks[segment] {
            let more = (factor(*shrink) - 1.0) * dot(along, r);
            r.iter_mut().zip(along).for_each(|(r, a)| *r += more * a);
        }
    }

    /// `ln det C` for so many samples of each output.
    #[must_use]
    pub fn log_determinant(&self, samples: &[f64]) -> f64 {
        let all = self.blocks.iter().flatten();
        let disturbances: f64 = all.map(|direction| -2.0 * direction.shrink.ln()).sum();
        let noise = self.noise.iter().zip(samples);
        disturbances + noise.map(|(noise, samples)| 2.0 * samples * noise.ln()).sum::<f64>()
    }
}

fn directions(columns: &[Vec<f64>], rows: Range<usize>) -> Option<Vec<Direction>> {
    let here: Vec<&[f64]> = columns.iter().map(|column| &column[rows.clone()]).collect();
    let here: Vec<&[f64]> =
        here.into_iter().filter(|column| column.iter().any(|v| v.abs() > 0.0)).collect();
    if here.is_empty() {
        return Some(Vec::new());
    }
    let w = Mat::from_fn(rows.len(), here.len(), |i, j| here[j][i]);
    let eigen = (w.transpose() * &w).self_adjoint_eigen(Side::Lower).ok()?;
    let u = &w * eigen.U();
    let of = |i: usize| {
        let lambda = eigen.S()[i];
        let length = lambda.sqrt();
        let along = (0..rows.len()).map(|k| u[(k, i)] / length).collect();
        Direction { along, shrink: (1.0 + lambda).sqrt().recip() }
    };
    Some((0..here.len()).filter(|i| SEEN < eigen.S()[*i]).map(of).collect())
}
