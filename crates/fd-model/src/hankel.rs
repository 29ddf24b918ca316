//! Hankel singular values: how much each balanced state matters between input and output.

use crate::{
    domain::TimeDomain, error::ModelError, linalg::singular_values, state_space::StateSpace,
};

impl<D: TimeDomain> StateSpace<D> {
    /// Hankel singular values, largest first, one per state.
    ///
    /// The square roots of the eigenvalues of `P Q`, computed as the singular values of
    /// `L_oᵀ L_c` from factors of the gramians (Laub, Heath, Paige and Ward 1987), so that the
    /// error is about `n ε` of the largest value rather than of its square.
    ///
    /// # Errors
    ///
    /// Returns an error when the model is unstable or within rounding of it.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// // P = Q = b²/2a
    /// let lag = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// assert!((lag.hankel_singular_values()?[0] - 0.5).abs() < 1e-15);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn hankel_singular_values(&self) -> Result<Vec<f64>, ModelError> {
        let factors = self.gramian_factors("the Hankel singular values")?;
        let product = factors.observability.transpose() * &factors.controllability;
        let mut values = singular_values(product.as_ref())?;
        // Factors with fewer columns than states leave out values that are zero.
        values.resize(self.nx(), 0.0);
        Ok(values)
    }
}
