//! Taking the zeros at infinity out of a noise filter, row by row.

use faer::{Mat, MatRef, Scale};
use fd_model::{ModelError, StateSpace, TimeDomain};
use fd_numeric::dense::Dense;

use crate::{
    error::DesignError,
    matrix::{blocks, spectral_norm, with_natural_states},
};

/// Relative singular values below this count as zero.
const RANK: f64 = 1e-9;

/// A system with a feedthrough of full row rank, and the proper filters that lead from the
/// outputs of the original one to its outputs, up to a common low-pass or delay.
pub(crate) struct Regular<D> {
    pub system: StateSpace<D>,
    pub filters: Vec<StateSpace<D>>,
}

/// Silverman's structure algorithm: rows without feedthrough are multiplied by `(s + a)/a`, or by
/// `z`, until there are none; the others are delayed alike to keep the filters proper.
pub(crate) fn regular<D: TimeDomain>(
    system: &StateSpace<D>,
    rate: f64,
) -> Result<Regular<D>, DesignError> {
    // The plant's states come with the noise, in units of their own.
    let system = with_natural_states(system)?;
    let (a, b, rows) = (system.a(), system.b(), system.ny());
    let domain = system.domain();
    let sampled = domain.highest_frequency().is_finite();
    let n = a.nrows();
    let or_one = |norm: f64| if 0.0 < norm { norm } else { 1.0 };
    let speed = or_one(spectral_norm(a));
    let (mut c, mut d) = (system.c().to_owned(), system.d().to_owned());
    let (mut filters, mut size) = (Vec::new(), 0.0_f64);
    for _ in 0..=n {
        let failed = |_| ModelError::NoConvergence { what: "zeros at infinity", order: n };
        let svd = d.full_svd().map_err(failed)?;
        // Without cancellation, and without states that the noise does not reach, whatever their units.
        let terms = sizes(c.as_ref()) * sizes(b);
        size = size.max(d.norm_l2() + terms.norm_l2() / speed);
        let direct = svd.S().column_vector().iter().filter(|&&s| RANK * size < s).count();
        if direct == rows {
            let system = StateSpace::new(a.to_owned(), b.to_owned(), c, d, domain)?;
            return Ok(Regular { system, filters });
        }
        let turn = svd.U().transpose().to_owned();
        filters.push(stage(
            turn.as_ref(),
            direct,
            if sampled { None } else { Some(rate) },
            domain,
        )?);
        let (turned_c, turned_d) = (&turn * &c, &turn * &d);
        let (kept, late) = turned_c.split_at_row(direct);
        let (advanced, fresh) = if sampled {
            (late * a, late * b)
        } else {
            (Scale(rate.recip()) * (late * a) + late, Scale(rate.recip()) * (late * b))
        };
        c = blocks(&[&[kept], &[advanced.as_ref()]]);
        d = blocks(&[&[turned_d.subrows(0, direct)], &[fresh.as_ref()]]);
    }
    Err(ModelError::Singular { role: "noise filter G_w" }.into())
}

fn sizes(m: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)].abs())
}

/// Turns the outputs, and filters the first `direct` of them by `a/(s + a)` or by `1/z`.
fn stage<D: TimeDomain>(
    turn: MatRef<'_, f64>,
    direct: usize,
    rate: Option<f64>,
    domain: D,
) -> Result<StateSpace<D>, DesignError> {
    let rows = turn.nrows();
    let (keep, enter) = rate.map_or((0.0, 1.0), |rate| (-rate, rate));
    let a = Mat::from_fn(direct, direct, |i, j| if i == j { keep } else { 0.0 });
    let b = Scale(enter) * turn.subrows(0, direct);
    let c = Mat::from_fn(rows, direct, |i, j| if i == j { 1.0 } else { 0.0 });
    let d = Mat::from_fn(rows, turn.ncols(), |i, j| if i < direct { 0.0 } else { turn[(i, j)] });
    Ok(StateSpace::new(a, b, c, d, domain)?)
}
