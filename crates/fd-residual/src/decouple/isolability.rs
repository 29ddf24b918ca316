//! Which faults any residual can tell apart.

use fd_model::{StateSpace, TimeDomain};

use super::design::LeftNullSpace;
use crate::{
    analysis::{Signature, UnknownInputs},
    error::DesignError,
    rank::RankTolerance,
};

/// One row per fault `i`: a bit `j` is set when some residual reacts to fault `i` and is
/// decoupled from fault `j` and from the disturbances; bit `i` of row `i` tells whether the fault
/// is detectable at all.
///
/// Two faults are isolable from each other when both bits are set. Derivatives (in continuous
/// time) or shifts of the signals are allowed, as in a structural analysis with mixed causality.
///
/// # Errors
///
/// Returns an error when the faults belong to another model.
///
/// # Examples
///
/// Two sensors of one lag: each is told apart from the other, and from the actuator.
///
/// ```
/// use faer::{Mat, mat};
/// use fd_model::{Continuous, StateSpace};
/// use fd_residual::{analysis::UnknownInputs, decouple::isolability};
///
/// let (b, c) = (mat![[1.0]], mat![[1.0], [1.0]]);
/// let lag = StateSpace::new(mat![[-1.0]], b, c, Mat::zeros(2, 1), Continuous)?;
/// let none = UnknownInputs::none(&lag);
/// let faults = none.clone().sensor(&lag, 0)?.sensor(&lag, 1)?.actuator(&lag, 0)?;
/// let rows: Vec<_> = isolability(&lag, &faults, &none)?.iter().map(ToString::to_string).collect();
/// assert_eq!(rows, ["111", "111", "111"]);
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
pub fn isolability<D: TimeDomain>(
    model: &StateSpace<D>,
    faults: &UnknownInputs,
    disturbances: &UnknownInputs,
) -> Result<Vec<Signature>, DesignError> {
    isolability_within(model, faults, disturbances, RankTolerance::default())
}

/// The same for a model that is known to a given tolerance.
///
/// # Errors
///
/// As [`isolability`].
pub fn isolability_within<D: TimeDomain>(
    model: &StateSpace<D>,
    faults: &UnknownInputs,
    disturbances: &UnknownInputs,
    tolerance: RankTolerance,
) -> Result<Vec<Signature>, DesignError> {
    let seen_without = |ignored: &[usize]| {
        let unknown = disturbances.and(&faults.select(ignored)?)?;
        match LeftNullSpace::within(model, &unknown, tolerance) {
            Err(DesignError::NothingLeft { .. }) => Ok(Signature(vec![false; faults.len()])),
            space => space?.detects(faults),
        }
    };
    let detectable = seen_without(&[])?;
    let columns = (0..faults.len()).map(|j| seen_without(&[j])).collect::<Result<Vec<_>, _>>()?;
    let bit = |i: usize, j: usize| if i == j { detectable.0[i] } else { columns[j].0[i] };
    let row = |i: usize| Signature((0..faults.len()).map(|j| bit(i, j)).collect());
    Ok((0..faults.len()).map(row).collect())
}
