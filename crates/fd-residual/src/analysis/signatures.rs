//! Which signatures any residual of a plant can have, and at which order.

use faer::{Mat, MatRef, Scale, c64};
use fd_model::{StateSpace, TimeDomain};

use super::{structure::Signature, unknown::UnknownInputs};
use crate::{
    error::DesignError,
    matrix::{blocks, complex},
    parity::{annihilators, input_map, observability},
};

/// Relative singular values below this count as zero.
const RANK: f64 = 1e-9;
/// A fault whose effect on all annihilators is below this fraction of its size is decoupled.
const DECOUPLED: f64 = 1e-7;
/// Faults beyond which the enumeration of `2ⁿ` signatures is refused.
const MOST_FAULTS: usize = 16;

/// A signature that some scalar residual has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Achievable {
    /// Faults that the residual reacts to; it is decoupled from all others.
    pub signature: Signature,
    /// Least parity order, which is the least order of a scalar residual generator.
    pub least_order: usize,
    /// Number of independent residuals that are decoupled from the others.
    pub dimension: usize,
    /// Orders of a minimal basis of these residuals, ascending, as far as found within the
    /// longest window.
    pub basis_orders: Vec<usize>,
}

/// All signatures that can be had with windows of at most `longest + 1` samples, in binary order.
///
/// A signature is achievable at order `s` when a parity vector of that order annihilates the
/// state, the disturbances and the faults with a zero bit, while none of the faults with a one
/// bit is annihilated by all such vectors (a combination of vectors then reacts to all of them).
/// With `frequencies` (rad/s; 0 for constant faults), each of these faults has to pass at each
/// frequency: strong signatures instead of weak ones.
///
/// The number of vectors with orders up to `s` in a minimal basis is the increase of the null
/// space's dimension from `s − 1` to `s`. No residual needs a higher order than the plant has
/// states, plus one for each decoupled input. The algebra is that of discrete time; for
/// continuous models it holds with derivatives in place of shifts.
///
/// # Errors
///
/// Returns an error when there is no fault or more than 16, or the sizes do not fit.
///
/// # Examples
///
/// Two sensors of one lag: each alone shows the actuator's faults and its own.
///
/// ```
/// use faer::{Mat, mat};
/// use fd_model::{Continuous, StateSpace};
/// use fd_residual::analysis::{UnknownInputs, achievable_signatures};
///
/// let (b, c) = (mat![[1.0]], mat![[1.0], [1.0]]);
/// let lag = StateSpace::new(mat![[-1.0]], b, c, Mat::zeros(2, 1), Continuous)?;
/// let none = UnknownInputs::none(&lag);
/// let faults = none.clone().sensor(&lag, 0)?.sensor(&lag, 1)?.actuator(&lag, 0)?;
/// let found = achievable_signatures(&lag, &faults, &none, &[], 3)?;
/// let found: Vec<_> = found.iter().map(|a| (a.signature.to_string(), a.least_order)).collect();
/// let expected = [("011", 1), ("101", 1), ("110", 0), ("111", 1)];
/// assert_eq!(found, expected.map(|(bits, order)| (bits.to_owned(), order)));
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
pub fn achievable_signatures<D: TimeDomain>(
    model: &StateSpace<D>,
    faults: &UnknownInputs,
    disturbances: &UnknownInputs,
    frequencies: &[f64],
    longest: usize,
) -> Result<Vec<Achievable>, DesignError> {
    let count = faults.len();
    if count == 0 {
        return Err(DesignError::Empty { what: "fault" });
    }
    if MOST_FAULTS < count {
        return Err(DesignError::Index { what: "fault", index: count - 1, count: MOST_FAULTS });
    }
    let windows = (0..=longest)
        .map(|order| Windows::of(model, faults, disturbances, frequencies, order))
        .collect::<Result<Vec<_>, _>>()?;
    let mut found = Vec::new();
    for code in 1..1_usize << count {
        let bits: Vec<bool> = (0..count).rev().map(|bit| code >> bit & 1 == 1).collect();
        found.extend(achieve(&windows, Signature(bits))?);
    }
    Ok(found)
}

fn achieve(windows: &[Windows], signature: Signature) -> Result<Option<Achievable>, DesignError> {
    let mut least_order = None;
    let (mut size, mut dimension) = (0, 0);
    let mut basis_orders = Vec::new();
    for (order, window) in windows.iter().enumerate() {
        let w = window.decoupled_from(&signature)?;
        // Each vector of lower order appears once more, shifted; the surplus is new.
        let increase = w.nrows().saturating_sub(size);
        basis_orders.extend(std::iter::repeat_n(order, increase.saturating_sub(dimension)));
        (size, dimension) = (w.nrows(), increase);
        if least_order.is_none() && window.all_react(w.as_ref(), &signature) {
            least_order = Some(order);
        }
    }
    Ok(least_order.map(|least_order| Achievable {
        signature,
        least_order,
        dimension,
        basis_orders,
    }))
}

/// What a window of one order sees of the state, the disturbances and each fault.
struct Windows {
    /// `[Γ T_d]`.
    nuisance: Mat<f64>,
    faults: Vec<Mat<f64>>,
    /// Powers of each point of the frequency axis, `[1; p; …; pˢ]`, as unit columns.
    waves: Vec<Mat<c64>>,
}

impl Windows {
    /// In units of time in which `‖A‖ = 1`, with outputs and signals scaled to unit size: all of
    /// this leaves orders and signatures as they are, and makes rank decisions mean something.
    fn of<D: TimeDomain>(
        model: &StateSpace<D>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
        frequencies: &[f64],
        order: usize,
    ) -> Result<Self, DesignError> {
        let norm = model.a().norm_l2();
        let speed = if norm > 0.0 { norm } else { 1.0 };
        let slow = Scale(speed.recip());
        let a = slow * model.a();
        let size = |i: usize| {
            let norm = model.c().row(i).norm_l2();
            if norm > 0.0 { norm } else { 1.0 }
        };
        let unit_rows =
            |m: MatRef<'_, f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] / size(i));
        let c = unit_rows(model.c());
        let map = |inputs: &UnknownInputs| {
            let entry = inputs.system(model)?;
            let (b, d) = (slow * entry.b(), unit_rows(entry.d()));
            let columns = (0..entry.nu()).map(|j| {
                let norm = b.col(j).norm_l2().hypot(d.col(j).norm_l2());
                let unit = Scale(if norm > 0.0 { norm.recip() } else { 1.0 });
                let (b, d) = (unit * b.subcols(j, 1), unit * d.subcols(j, 1));
                input_map(a.as_ref(), b.as_ref(), c.as_ref(), d.as_ref(), order)
            });
            Ok::<Vec<_>, DesignError>(columns.collect())
        };
        let mut nuisance = observability(a.as_ref(), c.as_ref(), order);
        for d in map(disturbances)? {
            nuisance = blocks(&[&[nuisance.as_ref(), d.as_ref()]]);
        }
        let wave = |&omega: &f64| {
            let point = model.domain().point(omega) / speed;
            let mut wave = Mat::from_fn(order + 1, 1, |_, _| c64::new(1.0, 0.0));
            for i in 1..=order {
                wave[(i, 0)] = wave[(i - 1, 0)] * point;
            }
            Scale(c64::new(wave.norm_l2().recip(), 0.0)) * wave
        };
        let waves = frequencies.iter().map(wave).collect();
        Ok(Self { nuisance, faults: map(faults)?, waves })
    }

    fn decoupled_from(&self, signature: &Signature) -> Result<Mat<f64>, DesignError> {
        let ignored = self.faults.iter().zip(&signature.0).filter(|(_, bit)| !**bit);
        let mut row = vec![self.nuisance.as_ref()];
        row.extend(ignored.map(|(map, _)| map.as_ref()));
        Ok(annihilators(blocks(&[&row]).as_ref(), RANK)?.0)
    }

    fn all_react(&self, w: MatRef<'_, f64>, signature: &Signature) -> bool {
        let wanted = self.faults.iter().zip(&signature.0).filter(|(_, bit)| **bit);
        let mut maps = wanted.map(|(map, _)| map);
        maps.all(|map| {
            let seen = w * map;
            let least = DECOUPLED * map.norm_l2();
            // A fault that grows like pᵏ gives the residual W T [1; p; …; pˢ] pᵏ.
            let passes = |wave: &Mat<c64>| least < (complex(seen.as_ref()) * wave).norm_l2();
            least < seen.norm_l2() && self.waves.iter().all(passes)
        })
    }
}
