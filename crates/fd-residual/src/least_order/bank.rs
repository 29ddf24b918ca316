//! One filter of least order per row of a structure matrix.

use fd_model::{Discrete, StateSpace, TimeDomain};

use super::design::LeastOrderDesign;
use crate::{
    analysis::UnknownInputs, error::DesignError, observer::ErrorPoles, rank::RankTolerance,
    structured::Structure,
};

/// A structured residual set in continuous or discrete time; in discrete time,
/// [`StructuredDesign`](crate::structured::StructuredDesign) with
/// [`RowMethod::LeastOrder`](crate::structured::RowMethod::LeastOrder) runs it.
#[derive(Clone, Debug)]
pub struct LeastOrderBank<D = Discrete> {
    rows: Vec<LeastOrderDesign<D>>,
}

impl<D: TimeDomain> LeastOrderBank<D> {
    /// One filter per row of the structure, with modes that die out at `rate` (1/s).
    ///
    /// # Errors
    ///
    /// As [`LeastOrderDesign::new`], for the first row that cannot be had.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::{
    ///     analysis::UnknownInputs, least_order::LeastOrderBank, rank::RankTolerance,
    ///     structured::Structure,
    /// };
    ///
    /// let (b, c) = (mat![[1.0]], mat![[1.0], [2.0]]);
    /// let lag = StateSpace::new(mat![[-1.0]], b, c, Mat::zeros(2, 1), Continuous)?;
    /// let none = UnknownInputs::none(&lag);
    /// let faults = none.clone().sensor(&lag, 0)?.sensor(&lag, 1)?.actuator(&lag, 0)?;
    /// let tolerance = RankTolerance::default();
    /// let bank = LeastOrderBank::new(&lag, &faults, &none, &Structure::Generalised, 4.0, tolerance)?;
    /// let orders: Vec<_> = bank.rows().iter().map(|row| row.order()).collect();
    /// assert_eq!(orders, [1, 1, 0]); // the last compares the two sensors
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(
        model: &StateSpace<D>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
        structure: &Structure,
        rate: f64,
        tolerance: RankTolerance,
    ) -> Result<Self, DesignError> {
        let poles = ErrorPoles::Rate(rate);
        let row = |signature| {
            let one = LeastOrderDesign::within;
            one(model, faults, disturbances, &signature, &poles, tolerance)
        };
        let rows: Result<_, DesignError> =
            structure.rows(faults.len())?.into_iter().map(row).collect();
        Ok(Self { rows: rows? })
    }

    /// The filters, in the order of the structure.
    #[must_use]
    pub fn rows(&self) -> &[LeastOrderDesign<D>] {
        &self.rows
    }
}
