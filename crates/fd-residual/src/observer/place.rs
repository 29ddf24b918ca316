//! Robust multi-output pole placement.

use std::f64::consts::SQRT_2;

use faer::{Mat, MatRef, Scale, c64};
use fd_core::Shape;
use fd_numeric::dense::Dense;

use super::observable::check_observable;
use crate::{
    error::{DesignError, no_convergence},
    matrix::{check_shape, complex},
};

/// Sweeps over all eigenvectors before the iteration ends at the latest.
const SWEEPS: usize = 60;
/// Relative gain of `|det X|` in a sweep below which the iteration ends.
const GAIN: f64 = 1e-4;
/// Singular values below this fraction of the largest count as zero in rank decisions.
const RANK: f64 = 1e-12;
/// Relative distance below which two wanted poles count as one.
const SAME_POLE: f64 = 1e-9;

/// An observer gain with prescribed poles.
#[derive(Clone, Debug)]
pub struct Placement {
    /// Gain `L` (states × outputs) such that `A − L C` has the wanted eigenvalues.
    pub gain: Mat<f64>,
    /// 2-norm condition number of the eigenvectors of `A − L C`: how many times further than a
    /// perturbation of the matrix its eigenvalues can move (Bauer and Fike 1960).
    pub condition: f64,
    /// Sweeps of the iteration.
    pub sweeps: usize,
}

/// Places the eigenvalues of `A − L C` and uses the freedom of several outputs to make them
/// insensitive.
///
/// Works on the dual `Aᵀ − Cᵀ Lᵀ`. An eigenvector for the pole `p` may be chosen anywhere in
/// `S_p = null(U₁ᵀ (Aᵀ − p I))`, where `U₁` spans the complement of the range of `Cᵀ` (Kautsky,
/// Nichols and Van Dooren 1985, theorem 3). Starting from a greedy choice, each eigenvector in
/// turn is replaced by the one in `S_p` that maximises `|det X|` with the others fixed: for a
/// real pole the projection of the normal of the others (their method 0), for a complex pair the
/// dominant eigenvector of a Hermitian form (Tits and Yang 1996, section III). `|det X|` with
/// unit columns never decreases.
///
/// # Errors
///
/// Returns an error when the poles are not as many as states, not closed under conjugation, or
/// repeated more often than the rank of `C`; when a mode is unobservable; or when the
/// eigenvectors cannot be made independent.
///
/// # Examples
///
/// ```
/// use faer::{c64, mat};
/// use fd_residual::observer::place_poles;
///
/// let a = mat![[1.0, 0.1], [0.0, 1.0]];
/// let c = mat![[1.0, 0.0]];
/// let placement = place_poles(a.as_ref(), c.as_ref(), &[c64::new(0.5, 0.2), c64::new(0.5, -0.2)])?;
/// // Hand: z² + (l₁ − 2) z + (1 − l₁ + 0.1 l₂) = z² − z + 0.29.
/// assert!((placement.gain[(0, 0)] - 1.0).abs() < 1e-12);
/// assert!((placement.gain[(1, 0)] - 2.9).abs() < 1e-12);
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
pub fn place_poles(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    poles: &[c64],
) -> Result<Placement, DesignError> {
    let n = a.nrows();
    check_shape("state matrix A", a, Shape::new(n, n))?;
    check_shape("output matrix C", c, Shape::new(c.nrows(), n))?;
    if poles.len() != n {
        return Err(DesignError::PoleCount { expected: n, found: poles.len() });
    }
    check_observable(a, c, |_| true)?;

    let range = Range::of(c, n)?;
    let spots = spots(poles, range.rank)?;
    let mut vectors = Eigenvectors::greedy(a, &range, spots, n)?;
    let sweeps = vectors.improve(n)?;

    // M = X Λ X⁻¹ in real arithmetic; then Cᵀ Lᵀ = Aᵀ − M has a solution by construction.
    let (x, lambda) = vectors.real(n);
    let svd = x.full_svd().map_err(|_| no_convergence("eigenvectors", n))?;
    let sigma = svd.S().column_vector();
    let condition = sigma[0] / sigma[n - 1];
    if condition.recip() <= f64::EPSILON {
        return Err(DesignError::PlacementCondition { condition });
    }
    let m = &x * lambda * svd.pseudoinverse();
    let gain = (&range.pseudoinverse * (a.transpose() - m)).transpose().to_owned();
    Ok(Placement { gain, condition, sweeps })
}

/// What of the state space `Cᵀ` reaches.
struct Range {
    rank: usize,
    /// `U₁`, an orthonormal basis of what it does not reach.
    complement: Mat<f64>,
    pseudoinverse: Mat<f64>,
}

impl Range {
    fn of(c: MatRef<'_, f64>, n: usize) -> Result<Self, DesignError> {
        let svd = c.transpose().full_svd().map_err(|_| no_convergence("singular values", n))?;
        let sigma = svd.S().column_vector();
        let cutoff = RANK * sigma.iter().copied().fold(0.0, f64::max);
        let rank = sigma.iter().filter(|&&s| cutoff < s).count();
        let complement = svd.U().subcols(rank, n - rank).to_owned();
        // V₁ Σ₁⁻¹ U₁ᵀ of the kept part only.
        let scaled = Mat::from_fn(rank, n, |i, j| svd.U()[(j, i)] / sigma[i]);
        Ok(Self { rank, complement, pseudoinverse: svd.V().subcols(0, rank) * scaled })
    }
}

/// A real pole, or one of a conjugate pair that stands for both.
#[derive(Clone, Copy, Debug)]
struct Spot {
    pole: c64,
    pair: bool,
}

/// Sorts poles into real ones and pairs, and checks that this is possible.
fn spots(poles: &[c64], rank: usize) -> Result<Vec<Spot>, DesignError> {
    let same = |p: c64, q: c64| (p - q).norm() <= SAME_POLE * p.norm().max(q.norm());
    let count = |p: c64| poles.iter().filter(|&&q| same(p, q)).count();
    let mut spots = Vec::new();
    for &pole in poles {
        let c64 { re, im } = pole;
        let multiplicity = count(pole);
        if !(re.is_finite() && im.is_finite()) || multiplicity != count(pole.conj()) {
            return Err(DesignError::PoleConjugate { re, im });
        }
        if rank < multiplicity {
            return Err(DesignError::PoleMultiplicity { re, im, multiplicity, rank });
        }
        let pair = !same(pole, pole.conj());
        if pair && 0.0 < im {
            spots.push(Spot { pole, pair });
        } else if !pair {
            spots.push(Spot { pole: c64::new(re, 0.0), pair });
        }
    }
    Ok(spots)
}

/// The eigenvectors of the dual closed loop, and where each of them may lie.
struct Eigenvectors {
    spots: Vec<Spot>,
    /// Orthonormal bases of the admissible subspaces `S_p`.
    spaces: Vec<Mat<c64>>,
    chosen: Vec<Mat<c64>>,
}

impl Eigenvectors {
    /// Admissible subspaces, and in each the vector that is farthest from those chosen before.
    fn greedy(
        a: MatRef<'_, f64>,
        range: &Range,
        spots: Vec<Spot>,
        n: usize,
    ) -> Result<Self, DesignError> {
        let mut all = Self { spots, spaces: Vec::new(), chosen: Vec::new() };
        let complement = complex(range.complement.transpose());
        for spot in &all.spots {
            let shifted = Mat::from_fn(n, n, |i, j| {
                let shift = if i == j { spot.pole } else { c64::new(0.0, 0.0) };
                c64::new(a[(j, i)], 0.0) - shift
            });
            let constraint = &complement * shifted;
            // Observability makes the n − rank constraints independent.
            let space = if range.rank == n {
                Mat::identity(n, n)
            } else {
                let svd = constraint.full_svd().map_err(|_| no_convergence("null space", n))?;
                svd.V().subcols(n - range.rank, range.rank).to_owned()
            };
            all.spaces.push(space);
        }
        for i in 0..all.spots.len() {
            // Others not chosen yet do not count, so the free space is large at first.
            let space = &all.spaces[i];
            let free = complex(complement_of(all.others(i).as_ref(), n)?.as_ref());
            let start = if all.spots[i].pair {
                widest_pair(space, &free, n)?
            } else {
                let seen = free.adjoint() * space;
                let svd = seen.full_svd().map_err(|_| no_convergence("eigenvectors", n))?;
                space * svd.V().subcols(0, 1)
            };
            all.chosen.push(start);
        }
        Ok(all)
    }

    /// Real basis of the span of all chosen eigenvectors but the `skip`-th.
    fn others(&self, skip: usize) -> Mat<f64> {
        let kept = (0..self.chosen.len()).filter(|&i| i != skip);
        let columns: Vec<_> =
            kept.flat_map(|i| real_columns(&self.chosen[i], self.spots[i])).collect();
        let n = self.spaces.first().map_or(0, Mat::nrows);
        Mat::from_fn(n, columns.len(), |i, j| columns[j][i])
    }

    /// Maximises `|det X|` by one eigenvector or pair at a time; returns the sweeps it took.
    fn improve(&mut self, n: usize) -> Result<usize, DesignError> {
        let mut before = self.volume(n);
        for sweep in 1..=SWEEPS {
            for i in 0..self.spots.len() {
                let free = complement_of(self.others(i).as_ref(), n)?;
                let width = if self.spots[i].pair { 2 } else { 1 };
                // Dependent others leave more room than needed; any of it will do.
                let free = complex(free.subcols(free.ncols() - width, width));
                let space = &self.spaces[i];
                self.chosen[i] = if self.spots[i].pair {
                    widest_pair(space, &free, n)?
                } else {
                    let x = space * (space.adjoint() * free);
                    let norm = x.norm_l2();
                    // Nothing of the normal lies in the space: no choice here helps.
                    if norm < f64::EPSILON {
                        continue;
                    }
                    x * Scale(c64::new(norm.recip(), 0.0))
                };
            }
            let after = self.volume(n);
            if after <= before * (1.0 + GAIN) {
                return Ok(sweep);
            }
            before = after;
        }
        Ok(SWEEPS)
    }

    fn volume(&self, n: usize) -> f64 {
        self.real(n).0.determinant().abs()
    }

    /// Real eigenvector matrix `X` and block-diagonal `Λ` with `M X = X Λ`.
    fn real(&self, n: usize) -> (Mat<f64>, Mat<f64>) {
        let x = self.others(usize::MAX);
        let mut lambda = Mat::zeros(n, n);
        let mut k = 0;
        for spot in &self.spots {
            let c64 { re, im } = spot.pole;
            lambda[(k, k)] = re;
            if spot.pair {
                // M (v + i w) = (re + i im)(v + i w).
                lambda[(k + 1, k + 1)] = re;
                lambda[(k, k + 1)] = im;
                lambda[(k + 1, k)] = -im;
                k += 1;
            }
            k += 1;
        }
        (x, lambda)
    }
}

/// A real eigenvector freed of its complex phase, or `√2 Re x` and `√2 Im x`, which are to `x`
/// and `x̄` what one unitary matrix makes of them, so norms and volumes are those of the pair.
fn real_columns(x: &Mat<c64>, spot: Spot) -> Vec<Vec<f64>> {
    if spot.pair {
        let part = |f: fn(c64) -> f64| (0..x.nrows()).map(|i| f(x[(i, 0)]) * SQRT_2).collect();
        return vec![part(|v| v.re), part(|v| v.im)];
    }
    let largest = (0..x.nrows()).map(|i| x[(i, 0)]).max_by(|p, q| p.norm().total_cmp(&q.norm()));
    let phase = largest.map_or(c64::new(1.0, 0.0), |v| v.conj() / v.norm());
    vec![(0..x.nrows()).map(|i| (x[(i, 0)] * phase).re).collect()]
}

/// Orthonormal basis of the complement of the columns of `m`, least dependent directions last.
fn complement_of(m: MatRef<'_, f64>, n: usize) -> Result<Mat<f64>, DesignError> {
    if m.ncols() == 0 {
        return Ok(Mat::identity(n, n));
    }
    let svd = m.full_svd().map_err(|_| no_convergence("eigenvectors", n))?;
    let sigma = svd.S().column_vector();
    let rank = sigma.iter().filter(|&&s| RANK * sigma[0] < s).count();
    Ok(svd.U().subcols(rank, n - rank).to_owned())
}

/// The unit `x` in `space` whose pair `x`, `x̄` spans the largest area within `free`.
///
/// With real orthonormal columns `f_i` of `free`, the area in the plane of `f_1`, `f_2` is
/// `|xᴴ H x|` with the Hermitian `H = (f₂ f₁ᵀ − f₁ f₂ᵀ) / 2i`. With more columns, during the
/// greedy start, the best plane of two of them is taken.
fn widest_pair(space: &Mat<c64>, free: &Mat<c64>, n: usize) -> Result<Mat<c64>, DesignError> {
    let seen = free.adjoint() * space;
    let m = seen.ncols();
    let mut best = None;
    let mut widest = -1.0;
    for j in 0..seen.nrows() {
        for i in 0..j {
            // Rows of `seen` are f_iᵀ S, so H restricted to `space` is built from them.
            let h = Mat::from_fn(m, m, |p, q| {
                let area = seen[(j, p)].conj() * seen[(i, q)] - seen[(i, p)].conj() * seen[(j, q)];
                area / c64::new(0.0, 2.0)
            });
            let eigen = h.symmetric_eigen().map_err(|_| no_convergence("eigenvectors", n))?;
            for k in 0..m {
                let size = eigen.S()[k].re.abs();
                if widest < size {
                    widest = size;
                    best = Some(space * eigen.U().subcols(k, 1));
                }
            }
        }
    }
    best.ok_or(DesignError::PlacementCondition { condition: f64::INFINITY })
}
