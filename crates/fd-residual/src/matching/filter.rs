//! The H-infinity and the H2 filter of a signal that the same unknown inputs drive.

use faer::{Mat, Scale, prelude::Solve};
use fd_model::{Continuous, ModelError, StateSpace};
use fd_numeric::dense::{Dense, DenseReal};

use crate::{
    error::DesignError,
    kalman::{riccati, symmetric},
    matrix::{blocks, spectral_norm},
    simulation::check_stable,
};

/// Relative accuracy of the least level.
const ACCURACY: f64 = 1e-4;

/// Relative accuracy of norms.
const NORM: f64 = 1e-8;

/// `ẋ = A x + B v`, measured `y = C x + D v` with `D Dᵀ = I` after scaling by `back`, wanted `z = C_z x + D_z v`.
///
/// With `v₁ = D v` and `v₂` the rest, `v₁ = y − C x` is known up to the state:
/// `ẋ = F x + B₁ y + B₂ v₂`, `z − D_z1 y = C' x + D₂ v₂`.
pub(super) struct Estimation {
    f: Mat<f64>,
    b1: Mat<f64>,
    b2: Mat<f64>,
    c: Mat<f64>,
    cz: Mat<f64>,
    dz1: Mat<f64>,
    d2: Mat<f64>,
    back: Mat<f64>,
    measured: StateSpace<Continuous>,
    wanted: StateSpace<Continuous>,
}

/// A filter from `y` to an estimate of `z`, and how far the two are apart.
pub(super) struct Estimate {
    pub filter: StateSpace<Continuous>,
    /// Of the transfer function from `v` to `z − ẑ`, H-infinity or H2.
    pub distance: f64,
    /// No filter is nearer than that, as far as the search has told.
    pub bound: f64,
}

impl Estimation {
    /// `measured` is driven by `[f; w]`, its feedthrough of full row rank; `wanted` by `f`, the first of them. Both stable.
    pub(super) fn new(
        measured: &StateSpace<Continuous>,
        wanted: &StateSpace<Continuous>,
    ) -> Result<Self, DesignError> {
        let idle = Mat::zeros(wanted.ny(), measured.nu() - wanted.nu());
        let wanted = wanted.beside(&StateSpace::gain(idle, Continuous)?)?;
        let (ny, none) = (measured.ny(), Mat::<f64>::zeros);
        let failed = || ModelError::Singular { role: "the noise and faults on the residual" };
        let root = (measured.d() * measured.d().transpose())
            .cholesky()
            .map_err(|_| failed())?
            .L()
            .to_owned();
        let back = root.lu().solve(Mat::<f64>::identity(ny, ny));
        let along = &back * measured.d();
        // Orthonormal rows of the rest.
        let svd = along.full_svd().map_err(|_| failed())?;
        let across = svd.V().subcols(ny, measured.nu() - ny).transpose().to_owned();

        let (n, nr) = (measured.nx(), wanted.nx());
        let a =
            blocks(&[&[measured.a(), none(n, nr).as_ref()], &[none(nr, n).as_ref(), wanted.a()]]);
        let b = blocks(&[&[measured.b()], &[wanted.b()]]);
        let c = blocks(&[&[(&back * measured.c()).as_ref(), none(ny, nr).as_ref()]]);
        let cz = blocks(&[&[none(wanted.ny(), n).as_ref(), wanted.c()]]);
        let (b1, b2) = (&b * along.transpose(), &b * across.transpose());
        let (dz1, d2) = (wanted.d() * along.transpose(), wanted.d() * across.transpose());
        Ok(Self {
            f: a - &b1 * &c,
            cz: cz - &dz1 * &c,
            b1,
            b2,
            c,
            dz1,
            d2,
            back,
            measured: measured.clone(),
            wanted,
        })
    }

    /// The filter for the level `γ`, given as `1/γ²`; zero gives the H2 filter. `None` when there is none.
    fn at(&self, inverse: f64) -> Result<Option<StateSpace<Continuous>>, DesignError> {
        let n = self.f.nrows();
        let k = if n == 0 {
            Mat::zeros(0, self.c.nrows())
        } else {
            let one = |size: usize| Mat::<f64>::identity(size, size);
            let g = Scale(inverse);
            // W = (I − D₂ᵀ D₂/γ²)⁻¹ on the side of the inputs.
            let w = (one(self.d2.ncols()) - g * self.d2.transpose() * &self.d2)
                .lu()
                .solve(one(self.d2.ncols()));
            let z =
                (one(self.d2.nrows()) - g * &self.d2 * self.d2.transpose()).lu().solve(&self.cz);
            let a = &self.f + g * &self.b2 * &w * self.d2.transpose() * &self.cz;
            let quadratic = self.c.transpose() * &self.c - g * self.cz.transpose() * z;
            let constant = &self.b2 * &w * self.b2.transpose();
            let Ok(p) = riccati(&a, &symmetric(&quadratic), &symmetric(&constant)) else {
                return Ok(None);
            };
            let failed = |_| ModelError::NoConvergence { what: "the filter", order: n };
            let values = p.symmetric_eigenvalues().map_err(failed)?;
            let least = values.first().copied().unwrap_or(0.0);
            if least.is_nan() || least < -1e-8 * p.norm_l2() {
                return Ok(None);
            }
            p * self.c.transpose()
        };
        let filter = StateSpace::new(
            &self.f - &k * &self.c,
            (&self.b1 + k) * &self.back,
            self.cz.clone(),
            &self.dz1 * &self.back,
            Continuous,
        );
        let Ok(filter) = filter else { return Ok(None) };
        Ok(check_stable("a matching filter", &filter).is_ok().then_some(filter))
    }

    /// `z − ẑ`, driven by `v`.
    fn error(
        &self,
        filter: &StateSpace<Continuous>,
    ) -> Result<StateSpace<Continuous>, DesignError> {
        Ok(self.wanted.difference(&self.measured.series(filter)?)?)
    }

    /// The H2 filter.
    pub(super) fn least_squares(&self) -> Result<Estimate, DesignError> {
        let none = ModelError::NoConvergence { what: "the H2 filter", order: self.f.nrows() };
        let filter = self.at(0.0)?.ok_or(none)?;
        let distance = self.error(&filter)?.h2_norm()?;
        Ok(Estimate { filter, distance, bound: distance })
    }

    /// The filter whose largest error over frequency is least.
    pub(super) fn least_peak(&self) -> Result<Estimate, DesignError> {
        const STEPS: usize = 80;
        let mut filter = self.least_squares()?.filter;
        let norm = |filter: &_| Ok::<_, DesignError>(self.error(filter)?.hinf_norm(NORM)?.norm);
        let mut distance = norm(&filter)?;
        // At infinite frequency v₂ leaves this whatever the filter is.
        let mut bound = spectral_norm(self.d2.as_ref());
        for _ in 0..STEPS {
            if distance - bound <= ACCURACY * distance {
                break;
            }
            let level = 0.5 * (distance + bound);
            let better = match self.at((level * level).recip())? {
                // The norm counts, not what the Riccati equation says about it.
                Some(found) => {
                    norm(&found).ok().filter(|size| *size < distance).map(|size| (found, size))
                }
                None => None,
            };
            match better {
                Some((found, size)) if size <= level * (1.0 + 1e-6) => {
                    (filter, distance) = (found, size);
                }
                _ => bound = level,
            }
        }
        Ok(Estimate { filter, distance, bound })
    }
}
