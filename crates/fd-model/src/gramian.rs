//! Controllability and observability gramians of stable models.

use faer::Mat;

use crate::{
    domain::TimeDomain,
    error::ModelError,
    linalg::{SmithFactors, balance, smith_factors},
    state_space::StateSpace,
};

/// Factors of the gramians in their own units: `P = L_c L_cᵀ`, `Q = L_o L_oᵀ`.
pub(crate) struct GramianFactors {
    pub controllability: Mat<f64>,
    pub observability: Mat<f64>,
}

impl<D: TimeDomain> StateSpace<D> {
    /// The controllability gramian `P`: the covariance of the states under white noise of unit
    /// intensity on the inputs.
    ///
    /// `A P + P Aᵀ + B Bᵀ = 0` in continuous and `A P Aᵀ − P + B Bᵀ = 0` in discrete time.
    ///
    /// # Errors
    ///
    /// Returns an error when the model is unstable or within rounding of it.
    pub fn controllability_gramian(&self) -> Result<Mat<f64>, ModelError> {
        let factor = self.gramian_factors("the controllability gramian")?.controllability;
        Ok(&factor * factor.transpose())
    }

    /// The observability gramian `Q`: `xᵀ Q x` is the energy of the free response from `x`.
    ///
    /// `Aᵀ Q + Q A + Cᵀ C = 0` in continuous and `Aᵀ Q A − Q + Cᵀ C = 0` in discrete time.
    ///
    /// # Errors
    ///
    /// Returns an error when the model is unstable or within rounding of it.
    pub fn observability_gramian(&self) -> Result<Mat<f64>, ModelError> {
        let factor = self.gramian_factors("the observability gramian")?.observability;
        Ok(&factor * factor.transpose())
    }

    /// Factors of both gramians, without ever squaring them.
    pub(crate) fn gramian_factors(&self, what: &'static str) -> Result<GramianFactors, ModelError> {
        if self.nx() == 0 {
            return Ok(GramianFactors {
                controllability: Mat::zeros(0, self.nu()),
                observability: Mat::zeros(0, self.ny()),
            });
        }
        let scaling = balance(self.a(), self.b(), self.c());
        let (a, b, c) = (scaling.a(self.a()), scaling.b(self.b()), scaling.c(self.c()));
        let system = self.domain().smith_system(a.as_ref(), b.as_ref(), c.as_ref());
        let factors = system.and_then(|system| {
            let order = self.nx();
            smith_factors(system).ok_or(ModelError::NoConvergence { what: "the gramian", order })
        });
        // Eigenvalues cost as much as the factors: they are asked only without another proof.
        if !factors.as_ref().is_ok_and(|factors| factors.proves_stability) {
            self.stable_poles(what)?;
        }
        let SmithFactors { controllability, observability, .. } = factors?;
        Ok(GramianFactors {
            controllability: scaling.undo_b(controllability.as_ref()),
            observability: scaling.undo_c(observability.transpose()).transpose().to_owned(),
        })
    }
}
