//! How far a residual lies from where each fault would put it.

use faer::{Mat, MatRef};
use fd_core::{HeapMap, LinMap, Scalar};
use fd_model::{ModelError, freeze};

use crate::{
    error::DesignError,
    matrix::spectral_norm,
    rank::{RankTolerance, decide},
};

/// For each fault the complement of the subspace in which it keeps the residual.
#[derive(Clone, Debug)]
pub struct FaultSpans<T: Scalar = f64> {
    /// Orthonormal rows that vanish on the subspace.
    outside: Vec<HeapMap<T>>,
    part: Vec<T>,
}

impl<T: Scalar> FaultSpans<T> {
    /// Subspaces given by their spanning columns, one matrix per fault, each with one row per
    /// residual channel.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no fault, or the matrices have different numbers of rows.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_residual::directional::FaultSpans;
    ///
    /// let first = mat![[1.0], [0.0]];
    /// let second = mat![[1.0], [1.0]];
    /// let mut spans = FaultSpans::<f64>::new(&[first.as_ref(), second.as_ref()])?;
    /// let mut index = [0.0; 2];
    /// spans.index_into(&[0.0, 2.0], &mut index); // at a right angle to the first
    /// assert!((index[0] - 1.0).abs() < 1e-15 && (index[1] - 0.5_f64.sqrt()).abs() < 1e-15);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(spans: &[MatRef<'_, f64>]) -> Result<Self, DesignError> {
        let Some(first) = spans.first() else {
            return Err(DesignError::Empty { what: "fault" });
        };
        let mut outside = Vec::new();
        for span in spans {
            let expected = fd_core::Shape::new(first.nrows(), span.ncols());
            crate::matrix::check_shape("directions of a fault", *span, expected)?;
            let decided = decide(*span, spectral_norm(*span), RankTolerance::default())?;
            let rows: Mat<f64> = decided.annihilators();
            outside.push(freeze("complement of a fault", rows.as_ref())?);
        }
        let most = outside.iter().map(|m: &HeapMap<T>| m.dims().rows).max().unwrap_or(0);
        if first.nrows() == 0 {
            return Err(ModelError::NoOutputs.into());
        }
        Ok(Self { outside, part: vec![T::zero(); most] })
    }

    /// Number of faults.
    #[must_use]
    pub fn len(&self) -> usize {
        self.outside.len()
    }

    /// Never: there is at least one fault.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.outside.is_empty()
    }

    /// Writes `‖r − P_i r‖ / ‖r‖` for each fault: 0 on its subspace, 1 at a right angle to it. A
    /// residual of zero says nothing and gives ones.
    ///
    /// Slices of other lengths are filled as far as they go.
    pub fn index_into(&mut self, r: &[T], index: &mut [T]) {
        let squared = |v: &[T]| v.iter().fold(T::zero(), |sum, &v| sum + v * v);
        let size = squared(r).sqrt();
        for (outside, index) in self.outside.iter().zip(index) {
            let part = &mut self.part[..outside.dims().rows];
            outside.mul_into(r, part);
            *index = if T::zero() < size { squared(part).sqrt() / size } else { T::one() };
        }
    }
}
