//! The matrices of a window: `Y = Γ x + T U`, oldest sample first.

use faer::{Mat, MatRef};

/// `Γ = [C; C A; …; C Aˢ]`.
pub(crate) fn observability(a: MatRef<'_, f64>, c: MatRef<'_, f64>, order: usize) -> Mat<f64> {
    let (ny, nx) = (c.nrows(), c.ncols());
    let mut gamma = Mat::zeros((order + 1) * ny, nx);
    let mut ca = c.to_owned();
    for i in 0..=order {
        gamma.submatrix_mut(i * ny, 0, ny, nx).copy_from(&ca);
        ca = &ca * a;
    }
    gamma
}

/// The block-Toeplitz matrix of Markov parameters `D, C B, C A B, …` below its diagonal.
pub(crate) fn input_map(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    d: MatRef<'_, f64>,
    order: usize,
) -> Mat<f64> {
    let (ny, nu) = (d.nrows(), d.ncols());
    let mut t = Mat::zeros((order + 1) * ny, (order + 1) * nu);
    let mut markov = d.to_owned();
    let mut ab = b.to_owned();
    for lag in 0..=order {
        for column in 0..=order - lag {
            t.submatrix_mut((column + lag) * ny, column * nu, ny, nu).copy_from(&markov);
        }
        markov = c * &ab;
        ab = a * &ab;
    }
    t
}
