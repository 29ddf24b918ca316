//! A row filter made stable by a scalar factor in front of it.

use faer::{Mat, MatRef, Scale, c64};
use fd_model::{ModelError, StateSpace, TimeDomain};

use crate::{
    error::DesignError,
    form::peak_gain,
    kalman::{Noises, filter},
    observer::pole_of_rate,
};

/// `M` and `N` with `M Y = N`, both stable, for one row `Y`.
pub(super) struct Factored<D> {
    /// Scalar.
    pub factor: StateSpace<D>,
    pub filter: StateSpace<D>,
}

/// A mode at the rate itself is left where it is, and must not lie on the line in which others are mirrored.
const JUST_BELOW: f64 = 0.999;

/// Mirrors the modes of a row that die out slower than `rate` (1/s), or grow, in the line just below that rate: a left
/// coprime factorisation `M = 1 − c (p − A + K c)⁻¹ K`, `N = d + c (p − A + K c)⁻¹ (B − K d)`.
pub(super) fn with_modes_at<D: TimeDomain>(
    row: &StateSpace<D>,
    rate: f64,
) -> Result<Factored<D>, DesignError> {
    let (a, b, c, d, domain) = (row.a(), row.b(), row.c(), row.d(), row.domain());
    let pole = pole_of_rate(domain, JUST_BELOW * rate)?.re;
    let sampled = domain.highest_frequency().is_finite();
    if slower(&row.poles()?, domain, rate)? == 0 {
        let factor = StateSpace::gain(Mat::identity(1, 1), domain)?;
        return Ok(Factored { factor, filter: row.clone() });
    }
    let n = row.nx();
    // Modes at that rate sit on the border of stability of this matrix.
    let moved = if sampled {
        Scale(pole.recip()) * a
    } else {
        a - Scale(pole) * Mat::<f64>::identity(n, n)
    };
    let quiet = Noises { q: Mat::zeros(n, n), s: Mat::zeros(n, 1), r: Mat::identity(1, 1) };
    let found = filter(domain, moved.as_ref(), c, &quiet)?;
    let k = Scale(if sampled { pole } else { 1.0 }) * found.gain;
    let closed = a - &k * c;
    let make = |b: MatRef<'_, f64>, d: MatRef<'_, f64>| {
        StateSpace::new(closed.clone(), b.to_owned(), c.to_owned(), d.to_owned(), domain)
    };
    let one = Mat::<f64>::identity(1, 1);
    let factor = make((Scale(-1.0) * &k).as_ref(), one.as_ref())?;
    let filter = make((b - &k * d).as_ref(), d)?;
    Ok(Factored { factor, filter })
}

/// How many of these modes die out slower than `rate`, or grow.
pub(super) fn slower<D: TimeDomain>(
    modes: &[c64],
    domain: D,
    rate: f64,
) -> Result<usize, DesignError> {
    let pole = pole_of_rate(domain, JUST_BELOW * rate)?.re;
    let sampled = domain.highest_frequency().is_finite();
    let is_slower = |mode: &c64| {
        if sampled { pole.abs() < mode.norm() } else { pole < mode.re }
    };
    Ok(modes.iter().filter(|mode| is_slower(mode)).count())
}

/// Largest response over frequency, relative to that of a reference.
pub(super) fn shares<D: TimeDomain>(
    error: &StateSpace<D>,
    reference: &StateSpace<D>,
) -> Result<f64, DesignError> {
    let size = peak_gain(reference)?.norm;
    if size.is_nan() || size <= 0.0 {
        return Err(ModelError::Singular { role: "the reference of a model matching" }.into());
    }
    Ok(peak_gain(error)?.norm / size)
}

/// One copy of `[u; y]` per member, the members above each other.
pub(super) fn above<D: TimeDomain>(
    rows: &[StateSpace<D>],
) -> Result<Option<StateSpace<D>>, DesignError> {
    let mut all: Option<StateSpace<D>> = None;
    for row in rows {
        all = Some(match all {
            Some(before) => before.above(row)?,
            None => row.clone(),
        });
    }
    Ok(all)
}

/// `diag(factors)`.
pub(super) fn diagonal<D: TimeDomain>(
    factors: &[StateSpace<D>],
    domain: D,
) -> Result<StateSpace<D>, DesignError> {
    let mut all = StateSpace::gain(Mat::zeros(0, 0), domain)?;
    for factor in factors {
        all = all.append(factor)?;
    }
    Ok(all)
}
