//! Cholesky factors of the small matrices of a fit.
//!
//! A fit factors thousands of matrices of two to fifteen rows. At that size these loops are an
//! order faster than a call of a library made for large ones.

/// The lower factor `L` of a symmetric positive definite `A = L Lᵀ`, row by row.
#[derive(Clone, Debug)]
pub(crate) struct Cholesky {
    l: Vec<f64>,
    n: usize,
}

impl Cholesky {
    /// Factors a matrix, of which the lower triangle is read; `None` when it is not positive
    /// definite.
    pub(crate) fn new(a: &[f64], n: usize) -> Option<Self> {
        let mut l = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
                let left = a[i * n + j] - known;
                l[i * n + j] = if i != j {
                    left / l[j * n + j]
                } else if f64::EPSILON * a[i * n + i] < left && left.is_finite() {
                    left.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(Self { l, n })
    }

    /// `b ← L⁻¹ b`.
    pub(crate) fn forward(&self, b: &mut [f64]) {
        for i in 0..self.n {
            let known: f64 = (0..i).map(|k| self.l[i * self.n + k] * b[k]).sum();
            b[i] = (b[i] - known) / self.l[i * self.n + i];
        }
    }

    /// `b ← L⁻ᵀ b`.
    pub(crate) fn backward(&self, b: &mut [f64]) {
        for i in (0..self.n).rev() {
            let known: f64 = (i + 1..self.n).map(|k| self.l[k * self.n + i] * b[k]).sum();
            b[i] = (b[i] - known) / self.l[i * self.n + i];
        }
    }

    /// `ln det A`.
    pub(crate) fn log_determinant(&self) -> f64 {
        2.0 * (0..self.n).map(|i| self.l[i * self.n + i].ln()).sum::<f64>()
    }
}
