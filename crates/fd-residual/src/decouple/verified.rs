//! Looking at a residual again, for what it was to be free of.

use faer::{Mat, MatRef};
use fd_model::{StateSpace, TimeDomain};

use crate::{
    analysis::{UnknownInputs, weak_structure},
    error::DesignError,
    form::ResidualForm,
    rank::RankDecision,
};

/// Refuses a form that any of these inputs reaches at any frequency; `gd` is their system, and `first`
/// the number of the form's first channel in the message.
pub(crate) fn refuse_what_passes<D: TimeDomain>(
    form: &ResidualForm<D>,
    unknown: &UnknownInputs,
    gd: &StateSpace<D>,
    first: usize,
    nearest: RankDecision,
) -> Result<(), DesignError> {
    for (row, seen) in weak_structure(form, gd)?.iter().enumerate() {
        if let Some(passes) = seen.0.iter().position(|&bit| bit) {
            let name = unknown.names()[passes].clone();
            return Err(DesignError::NotDecoupled { row: first + row, name, nearest });
        }
    }
    Ok(())
}

/// The same for unknown inputs that enter the states along the columns of `E`.
pub(crate) fn refuse_what_enters<D: TimeDomain>(
    form: &ResidualForm<D>,
    model: &StateSpace<D>,
    e: MatRef<'_, f64>,
    nearest: RankDecision,
) -> Result<(), DesignError> {
    let none = Mat::zeros(model.ny(), e.ncols());
    let unknown = UnknownInputs::new("unknown input", e.to_owned(), none)?;
    refuse_what_passes(form, &unknown, &unknown.system(model)?, 0, nearest)
}
