//! The largest set of state combinations that an unknown input leaves alone.

use faer::Mat;
use fd_model::{NaturalUnits, StateSpace, TimeDomain};

use crate::{
    analysis::UnknownInputs,
    error::DesignError,
    matrix::blocks,
    natural::Natural,
    rank::{RankDecision, RankTolerance, decide},
};

/// `V A = Φ V + G C` and `V E = G F` with as many rows of `V` as possible, orthonormal in natural units;
/// all here is in natural units of signals and of time.
#[derive(Clone, Debug)]
pub(super) struct Invariant {
    pub v: Mat<f64>,
    pub phi: Mat<f64>,
    pub g: Mat<f64>,
    /// Orthonormal rows with `W [C N, F] = 0`, where `N` spans what `V` leaves out.
    pub w: Mat<f64>,
    /// `W C Vᵀ`.
    pub m: Mat<f64>,
    pub units: NaturalUnits,
    /// Size of `[A E; C F]`, which a relative change of the data moves by as much.
    pub scale: f64,
    /// The nearest decision.
    pub nearest: RankDecision,
    /// Smallest value that was kept in any.
    pub kept: f64,
}

/// For a plant with these unknown inputs.
pub(super) fn invariant<D: TimeDomain>(
    model: &StateSpace<D>,
    unknown: &UnknownInputs,
    tolerance: RankTolerance,
) -> Result<Invariant, DesignError> {
    let n = model.nx();
    let Natural { a, b: e, c, d: f, units } = Natural::of(model, unknown)?;
    let scale = [a.norm_l2(), e.norm_l2(), c.norm_l2(), f.norm_l2()];
    let scale = scale.into_iter().fold(0.0, f64::hypot);

    let mut nearest = RankDecision::clear(tolerance);
    let mut kept = 1.0_f64;
    let mut note = |decision: RankDecision| {
        nearest = nearest.nearer(decision);
        if 0 < decision.rank {
            kept = kept.min(decision.smallest_kept);
        }
    };
    let mut v = Mat::<f64>::identity(n, n);
    loop {
        // Orthonormal columns that no row of V sees; V is orthonormal, so of unit size.
        let rest = decide(v.transpose(), 1.0, tolerance)?.annihilators().transpose().to_owned();
        let seen = blocks(&[&[(&c * &rest).as_ref(), f.as_ref()]]);
        let moved = blocks(&[&[(&v * &a * &rest).as_ref(), (&v * &e).as_ref()]]);
        let both =
            decide(blocks(&[&[moved.as_ref()], &[seen.as_ref()]]).as_ref(), scale, tolerance)?;
        note(both.decision);
        let free = both.annihilators();
        // Part of an orthonormal matrix.
        let part = decide((free.subcols(0, v.nrows()) * &v).as_ref(), 1.0, tolerance)?;
        note(part.decision);
        let next = part.row_space();
        if next.nrows() < v.nrows() {
            v = next;
            continue;
        }
        let seen = decide(seen.as_ref(), scale, tolerance)?;
        note(seen.decision);
        let g = &moved * seen.pseudoinverse();
        let phi = (&v * &a - &g * &c) * v.transpose();
        let w = seen.annihilators();
        let m = &w * &c * v.transpose();
        return Ok(Invariant { v, phi, g, w, m, units, scale, nearest, kept });
    }
}
