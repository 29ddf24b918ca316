//! The largest set of state combinations that an unknown input leaves alone.

use faer::{Mat, MatRef, Scale, linalg::solvers::Svd};
use fd_model::ModelError;

use crate::{
    error::DesignError,
    matrix::{blocks, spectral_norm},
    parity::annihilators,
};

/// Relative singular values below this count as zero.
const TOLERANCE: f64 = 1e-9;

/// `V A = Φ V + G C` and `V E = G F` with orthonormal rows `V`, as many as possible.
pub(super) struct Invariant {
    pub(super) v: Mat<f64>,
    pub(super) phi: Mat<f64>,
    pub(super) g: Mat<f64>,
    /// Orthonormal rows with `W [C N, F] = 0`, where `N` spans what `V` leaves out.
    pub(super) w: Mat<f64>,
}

/// In units of time in which `‖A‖ = 1` and of signals in which rows of `C` and entries have unit
/// size: this leaves the answer as it is, and makes rank decisions mean something.
pub(super) fn invariant(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    e: MatRef<'_, f64>,
    f: MatRef<'_, f64>,
) -> Result<Invariant, DesignError> {
    let (n, ny) = (a.nrows(), c.nrows());
    let or_one = |norm: f64| if 0.0 < norm { norm } else { 1.0 };
    let speed = or_one(spectral_norm(a));
    let size: Vec<f64> = (0..ny).map(|i| or_one(c.row(i).norm_l2())).collect();
    let unit = |m: MatRef<'_, f64>| Mat::from_fn(ny, m.ncols(), |i, j| m[(i, j)] / size[i]);
    let a = Scale(speed.recip()) * a;
    let c = unit(c);
    let entry: Vec<f64> = (0..e.ncols())
        .map(|j| {
            let into_outputs = (0..ny).map(|i| (f[(i, j)] / size[i]).powi(2)).sum::<f64>();
            or_one((e.col(j).squared_norm_l2() / speed.powi(2) + into_outputs).sqrt())
        })
        .collect();
    let e = Mat::from_fn(n, e.ncols(), |i, j| e[(i, j)] / speed / entry[j]);
    let f = Mat::from_fn(ny, f.ncols(), |i, j| f[(i, j)] / size[i] / entry[j]);

    let mut v = Mat::<f64>::identity(n, n);
    loop {
        let rest = complement(&v)?;
        let seen = blocks(&[&[(&c * &rest).as_ref(), f.as_ref()]]);
        let moved = blocks(&[&[(&v * &a * &rest).as_ref(), (&v * &e).as_ref()]]);
        let both = blocks(&[&[moved.as_ref()], &[seen.as_ref()]]);
        let (kept, _) = annihilators(both.as_ref(), TOLERANCE)?;
        let next = row_space((kept.subcols(0, v.nrows()) * &v).as_ref())?;
        if next.nrows() < v.nrows() {
            v = next;
            continue;
        }
        let g_unit = &moved * pseudoinverse(seen.as_ref())?;
        let phi = (&v * &a - &g_unit * &c) * v.transpose();
        let (w_unit, _) = annihilators(seen.as_ref(), TOLERANCE)?;
        let by_size = |m: &Mat<f64>, gain: f64| {
            Mat::from_fn(m.nrows(), ny, |i, j| m[(i, j)] * gain / size[j])
        };
        return Ok(Invariant {
            phi: Scale(speed) * phi,
            g: by_size(&g_unit, speed),
            w: by_size(&w_unit, 1.0),
            v,
        });
    }
}

/// Orthonormal columns that no row of `v` sees.
fn complement(v: &Mat<f64>) -> Result<Mat<f64>, DesignError> {
    Ok(annihilators(v.transpose(), TOLERANCE)?.0.transpose().to_owned())
}

/// Orthonormal rows with the same span; `m` is part of an orthonormal matrix, so of unit size.
fn row_space(m: MatRef<'_, f64>) -> Result<Mat<f64>, DesignError> {
    if m.nrows() == 0 || m.ncols() == 0 {
        return Ok(Mat::zeros(0, m.ncols()));
    }
    let svd = decompose(m)?;
    let rank = svd.S().column_vector().iter().filter(|&&s| TOLERANCE < s).count();
    Ok(svd.V().subcols(0, rank).transpose().to_owned())
}

/// Moore-Penrose inverse with the rank decision of this room.
fn pseudoinverse(m: MatRef<'_, f64>) -> Result<Mat<f64>, DesignError> {
    if m.nrows() == 0 || m.ncols() == 0 {
        return Ok(Mat::zeros(m.ncols(), m.nrows()));
    }
    let svd = decompose(m)?;
    let sigma = svd.S().column_vector();
    let rank = sigma.iter().filter(|&&s| TOLERANCE * sigma[0] < s).count();
    let scaled = Mat::from_fn(rank, m.nrows(), |i, j| svd.U()[(j, i)] / sigma[i]);
    Ok(svd.V().subcols(0, rank) * scaled)
}

fn decompose(m: MatRef<'_, f64>) -> Result<Svd<f64>, DesignError> {
    let what = "invariant subspace";
    m.svd().map_err(|_| ModelError::NoConvergence { what, order: m.nrows() }.into())
}
