//! Diagonal scaling of the states, so that rounding errors do not depend on their units.

use faer::{Mat, MatRef};

/// States are measured in these units: `x = diag(units) x_scaled`.
///
/// All units are powers of two, so that scaling is free of rounding errors.
pub(crate) struct Scaling {
    units: Vec<f64>,
}

/// Finds units in which the rows of `[A B]` and the columns of `[A; C]` are of equal size.
///
/// Parlett and Reinsch 1969, with the inputs and outputs added; pass matrices without columns
/// or rows to balance `A` alone.
pub(crate) fn balance(a: MatRef<'_, f64>, b: MatRef<'_, f64>, c: MatRef<'_, f64>) -> Scaling {
    const SWEEPS: usize = 100;
    // A smaller gain is not worth another sweep (the value in LAPACK's `gebal`).
    const WORTHWHILE: f64 = 0.95;

    let n = a.nrows();
    let mut units = vec![1.0; n];
    for _ in 0..SWEEPS {
        let mut settled = true;
        for i in 0..n {
            let others = || (0..n).filter(move |&j| j != i);
            let row = others().map(|j| a[(i, j)].abs() * units[j]).sum::<f64>()
                + (0..b.ncols()).map(|j| b[(i, j)].abs()).sum::<f64>();
            let col = others().map(|j| a[(j, i)].abs() / units[j]).sum::<f64>()
                + (0..c.nrows()).map(|j| c[(j, i)].abs()).sum::<f64>();
            let (row, col) = (row / units[i], col * units[i]);
            if row <= 0.0 || col <= 0.0 || !(row / col).is_normal() {
                continue;
            }
            let step = (row / col).sqrt().log2().round().exp2();
            if col * step + row / step < WORTHWHILE * (row + col) {
                units[i] *= step;
                settled = false;
            }
        }
        if settled {
            break;
        }
    }
    Scaling { units }
}

impl Scaling {
    /// `diag(units)⁻¹ A diag(units)`.
    pub(crate) fn a(&self, a: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * (self.units[j] / self.units[i]))
    }

    /// `diag(units)⁻¹ B`.
    pub(crate) fn b(&self, b: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)] / self.units[i])
    }

    /// `C diag(units)`.
    pub(crate) fn c(&self, c: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(c.nrows(), c.ncols(), |i, j| c[(i, j)] * self.units[j])
    }

    /// Undoes [`Scaling::a`].
    pub(crate) fn undo_a(&self, a: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * (self.units[i] / self.units[j]))
    }

    /// Undoes [`Scaling::b`].
    pub(crate) fn undo_b(&self, b: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)] * self.units[i])
    }

    /// Undoes [`Scaling::c`].
    pub(crate) fn undo_c(&self, c: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(c.nrows(), c.ncols(), |i, j| c[(i, j)] / self.units[j])
    }
}
