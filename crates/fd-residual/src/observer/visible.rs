//! Placing the poles of what the outputs show, and checking that the rest decays by itself.

use faer::{Mat, MatRef, c64};
use fd_model::{StateSpace, TimeDomain};
use fd_numeric::dense::{Dense, DenseReal};

use super::place::place_poles;
use crate::{
    analysis::UnknownInputs,
    error::{DesignError, no_convergence},
    kalman::at_least_as_fast,
    matrix::{blocks, spectral_norm},
    natural::Natural,
    rank::{RankTolerance, decide},
};

/// Directions that grow by less than this in a step of the staircase are not new.
const NEW: f64 = 1e-10;

/// Where the poles of an estimation error are to lie.
///
/// # Examples
///
/// ```
/// use fd_residual::observer::ErrorPoles;
///
/// let poles = ErrorPoles::Rate(2.0); // exp(−2 t), or faster
/// assert_ne!(poles, ErrorPoles::DeadBeat);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum ErrorPoles {
    /// As given, one per state that the outputs show; complex ones with their conjugates.
    Given(Vec<c64>),
    /// Wherever a filter puts them whose modes all die out at least at this rate (1/s): well
    /// conditioned for any number of states and outputs.
    Rate(f64),
    /// All poles at the origin of the `z` plane, as nearly as distinct poles allow; for discrete
    /// time only.
    DeadBeat,
}

impl ErrorPoles {
    /// Values for `count` poles, of which `together` may coincide.
    pub(crate) fn values<D: TimeDomain>(
        &self,
        domain: D,
        count: usize,
        together: usize,
    ) -> Result<Vec<c64>, DesignError> {
        let sampled = domain.highest_frequency().is_finite();
        match self {
            Self::Given(poles) if poles.len() == count => Ok(poles.clone()),
            Self::Given(poles) => {
                Err(DesignError::PoleCount { expected: count, found: poles.len() })
            }
            Self::Rate(rate) => Ok(vec![pole_of_rate(domain, *rate)?; count]),
            Self::DeadBeat if sampled && count <= together => Ok(vec![c64::new(0.0, 0.0); count]),
            Self::DeadBeat if sampled => {
                // Full eigenvectors exclude Jordan blocks: a few small poles die out as fast.
                let spread = (0..).flat_map(|group| std::iter::repeat_n(group, together.max(1)));
                Ok(spread.take(count).map(|group| c64::new(1e-3 * f64::from(group), 0.0)).collect())
            }
            Self::DeadBeat => Err(DesignError::Speed { factor: f64::INFINITY }),
        }
    }
}

/// The pole of a mode that dies out at `rate` (1/s): `−rate`, or `exp(−rate Ts)`.
pub(crate) fn pole_of_rate<D: TimeDomain>(domain: D, rate: f64) -> Result<c64, DesignError> {
    if !(0.0 < rate && rate.is_finite()) {
        return Err(DesignError::Speed { factor: rate });
    }
    let nyquist = domain.highest_frequency();
    let pole =
        if nyquist.is_finite() { (-rate * std::f64::consts::PI / nyquist).exp() } else { -rate };
    Ok(c64::new(pole, 0.0))
}

/// Orthonormal columns that span what the outputs show of the state, and those that span the
/// rest, by the observability staircase.
pub(crate) fn visible_part(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
) -> Result<(Mat<f64>, Mat<f64>), DesignError> {
    let sizes = [spectral_norm(a), spectral_norm(c)];
    visible_part_of(a, c, sizes.map(|size| size.max(f64::MIN_POSITIVE)), NEW)
}

/// The same with the sizes of the data that `A` and `C` were computed from, which are larger than their
/// own where those are nothing but rounding.
pub(crate) fn visible_part_of(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    [speed, mut size]: [f64; 2],
    new: f64,
) -> Result<(Mat<f64>, Mat<f64>), DesignError> {
    let n = a.nrows();
    let mut seen = Mat::<f64>::zeros(n, 0);
    let mut newest = c.transpose().to_owned();
    while seen.ncols() < n && 0 < newest.ncols() {
        // Twice is enough: what a second projection removes is rounding of the first.
        for _ in 0..2 {
            newest = &newest - &seen * (seen.transpose() * &newest);
        }
        let svd = newest.full_svd().map_err(|_| no_convergence("staircase", n))?;
        let grown = svd.S().column_vector().iter().filter(|&&s| new * size < s).count();
        let fresh = svd.U().subcols(0, grown).to_owned();
        seen = blocks(&[&[seen.as_ref(), fresh.as_ref()]]);
        newest = a.transpose() * fresh;
        size = speed;
    }
    if seen.ncols() == 0 {
        return Ok((seen, Mat::identity(n, n)));
    }
    let svd = seen.full_svd().map_err(|_| no_convergence("staircase", n))?;
    let rest = svd.U().subcols(seen.ncols(), n - seen.ncols()).to_owned();
    Ok((seen, rest))
}

/// A gain `L` that gives the visible part of `A − L C` the wanted poles.
///
/// # Errors
///
/// Fails as [`place_poles`] does, or with what `hidden` makes of a mode that no gain moves and
/// that does not decay.
pub(crate) fn place_visible<D: TimeDomain>(
    domain: D,
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    poles: &ErrorPoles,
    hidden: impl Fn(c64) -> DesignError,
) -> Result<Mat<f64>, DesignError> {
    let n = a.nrows();
    if n == 0 {
        return Ok(Mat::zeros(0, c.nrows()));
    }
    let (seen, rest) = visible_part(a, c)?;
    if 0 < rest.ncols() {
        let block = rest.transpose() * a * &rest;
        let modes = block.modes().map_err(|_| no_convergence("eigenvalues", n))?;
        if let Some(&mode) = modes.iter().find(|&&mode| !domain.decays(mode)) {
            return Err(hidden(mode));
        }
    }
    if seen.ncols() == 0 {
        return Ok(Mat::zeros(n, c.nrows()));
    }
    let (part, shown) = (seen.transpose() * a * &seen, c * &seen);
    if let ErrorPoles::Rate(rate) = poles {
        let slowest = pole_of_rate(domain, *rate)?.re;
        return Ok(seen * at_least_as_fast(domain, part.as_ref(), shown.as_ref(), slowest)?);
    }
    let together = rank(shown.as_ref())?;
    let wanted = poles.values(domain, seen.ncols(), together)?;
    let placement = place_poles(part.as_ref(), shown.as_ref(), &wanted)?;
    Ok(seen * placement.gain)
}

/// Number of singular values above the relative tolerance.
pub(crate) fn rank(m: MatRef<'_, f64>) -> Result<usize, DesignError> {
    if m.nrows() == 0 || m.ncols() == 0 {
        return Ok(0);
    }
    let sigma = m.sigmas().map_err(|_| no_convergence("rank", m.nrows()))?;
    Ok(sigma.iter().filter(|&&s| NEW * sigma[0] < s && 0.0 < s).count())
}

/// The plant with an unknown input that enters along `E`, in natural units.
pub(crate) fn natural<D: TimeDomain>(
    model: &StateSpace<D>,
    e: MatRef<'_, f64>,
) -> Result<Natural, DesignError> {
    let none = Mat::zeros(model.ny(), e.ncols());
    Natural::of(model, &UnknownInputs::new("unknown input", e.to_owned(), none)?)
}

/// Ranks of `C E` and of `E`, relative to the data that they were computed from.
pub(crate) fn entry_ranks(natural: &Natural) -> Result<[usize; 2], DesignError> {
    let Natural { b: e, c, .. } = natural;
    let of = |m: MatRef<'_, f64>, scale: f64| {
        Ok::<_, DesignError>(decide(m, scale, RankTolerance::default())?.decision.rank)
    };
    Ok([of((c * e).as_ref(), c.norm_l2() * e.norm_l2())?, of(e.as_ref(), e.norm_l2())?])
}
