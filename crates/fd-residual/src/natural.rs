//! A plant as the unknown inputs see it.

use faer::{Mat, Scale};
use fd_model::{NaturalUnits, StateSpace, TimeDomain};

use crate::{analysis::UnknownInputs, error::DesignError, matrix::blocks};

/// A plant whose only inputs are the unknown ones, in natural units of signals and of time.
#[derive(Clone, Debug)]
pub(crate) struct Natural {
    pub a: Mat<f64>,
    pub b: Mat<f64>,
    pub c: Mat<f64>,
    pub d: Mat<f64>,
    /// Of the unknown inputs, not of the known ones.
    pub units: NaturalUnits,
}

impl Natural {
    /// The known inputs have no part in rank decisions, but they show how large the states are that no
    /// unknown one reaches.
    pub(crate) fn of<D: TimeDomain>(
        model: &StateSpace<D>,
        unknown: &UnknownInputs,
    ) -> Result<Self, DesignError> {
        let entry = unknown.system(model)?;
        let all = StateSpace::new(
            model.a().to_owned(),
            blocks(&[&[model.b(), entry.b()]]),
            model.c().to_owned(),
            blocks(&[&[model.d(), entry.d()]]),
            model.domain(),
        )?;
        let mut units = all.natural_units();
        units.inputs.drain(..model.nu());
        let natural = entry.in_units(&units)?;
        let slow = Scale(units.rate.recip());
        let (a, b) = (slow * natural.a(), slow * natural.b());
        Ok(Self { a, b, c: natural.c().to_owned(), d: natural.d().to_owned(), units })
    }
}
