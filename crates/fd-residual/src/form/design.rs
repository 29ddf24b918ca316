//! The realisation of `[H_u H_y]` and what can be asked of it.

use std::fmt::Debug;

use faer::{Mat, MatRef, c64};
use fd_core::{IoDims, Shape, ShapeError, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace, TimeDomain};

use super::frequency::{FrequencyAxis, frequency_grid, response_of};
use crate::{
    error::DesignError,
    matrix::{blocks, spectral_norm},
};

/// A residual generator at design time.
///
/// Every design can be checked and plotted through its [`form`](Self::form), and run through
/// [`build`](Self::build). The designs also have a `freeze` of their own for `f32` or fixed
/// storage.
pub trait GeneratorDesign: Debug + Send + Sync {
    /// Channels of the plant.
    fn io(&self) -> IoDims;

    /// Number of residual channels.
    fn residual_len(&self) -> usize;

    /// The transfer functions from `u` and `y` to `r`.
    ///
    /// # Errors
    ///
    /// Returns an error when an inner realisation cannot be built.
    fn form(&self) -> Result<ResidualForm, DesignError>;

    /// The generator in `f64` with sizes known at run time.
    ///
    /// # Errors
    ///
    /// Returns an error when an inner part cannot be frozen.
    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError>;
}

impl<G: GeneratorDesign + ?Sized> GeneratorDesign for Box<G> {
    fn io(&self) -> IoDims {
        (**self).io()
    }

    fn residual_len(&self) -> usize {
        (**self).residual_len()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        (**self).form()
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        (**self).build()
    }
}

/// One joint realisation of `r = H_u u + H_y y` with input `[u; y]`.
#[derive(Clone, Debug)]
pub struct ResidualForm<D = Discrete> {
    io: IoDims,
    system: StateSpace<D>,
}

impl<D: TimeDomain> ResidualForm<D> {
    /// A form from its realisation, whose first `io.nu` inputs are `u` and the other `io.ny`
    /// are `y`.
    ///
    /// # Errors
    ///
    /// Returns an error when the realisation has not `io.nu + io.ny` inputs.
    ///
    /// # Examples
    ///
    /// The parity equation `r(k) = y(k) − 0.9 y(k−1) − u(k−1)` of `y(k+1) = 0.9 y(k) + u(k)`:
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::IoDims;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::ResidualForm;
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let plant = StateSpace::new(mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let system = StateSpace::new(
    ///     mat![[0.0, 0.0], [0.0, 0.0]],
    ///     mat![[1.0, 0.0], [0.0, 1.0]],
    ///     mat![[-1.0, -0.9]],
    ///     mat![[0.0, 1.0]],
    ///     domain,
    /// )?;
    /// let form = ResidualForm::new(IoDims { nu: 1, ny: 1 }, system)?;
    /// assert!(form.consistency(&plant)? < 1e-14);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(io: IoDims, system: StateSpace<D>) -> Result<Self, DesignError> {
        if system.nu() != io.nu + io.ny {
            return Err(ShapeError {
                role: "feedthrough of [u; y] to r",
                expected: Shape::new(system.ny(), io.nu + io.ny),
                found: Shape::new(system.ny(), system.nu()),
            }
            .into());
        }
        Ok(Self { io, system })
    }

    /// Channels of the plant.
    #[must_use]
    pub fn io(&self) -> IoDims {
        self.io
    }

    /// Number of residual channels.
    #[must_use]
    pub fn residual_len(&self) -> usize {
        self.system.ny()
    }

    /// The joint realisation from `[u; y]` to `r`.
    #[must_use]
    pub fn system(&self) -> &StateSpace<D> {
        &self.system
    }

    /// `H_u`, from the inputs to the residual.
    ///
    /// # Errors
    ///
    /// Never fails for a checked form.
    pub fn hu(&self) -> Result<StateSpace<D>, DesignError> {
        self.columns(0, self.io.nu)
    }

    /// `H_y`, from the outputs to the residual.
    ///
    /// # Errors
    ///
    /// Never fails for a checked form.
    pub fn hy(&self) -> Result<StateSpace<D>, DesignError> {
        self.columns(self.io.nu, self.io.ny)
    }

    fn columns(&self, from: usize, count: usize) -> Result<StateSpace<D>, DesignError> {
        let s = &self.system;
        Ok(StateSpace::new(
            s.a().to_owned(),
            s.b().subcols(from, count).to_owned(),
            s.c().to_owned(),
            s.d().subcols(from, count).to_owned(),
            s.domain(),
        )?)
    }

    /// The form of the residual `W r`.
    ///
    /// # Errors
    ///
    /// Returns an error when `W` has not one column per residual channel.
    pub fn weighted(&self, w: MatRef<'_, f64>) -> Result<Self, DesignError> {
        let s = &self.system;
        let expected = Shape::new(w.nrows(), self.residual_len());
        crate::matrix::check_shape("weighting W", w, expected)?;
        let (a, b) = (s.a().to_owned(), s.b().to_owned());
        let system = StateSpace::new(a, b, w * s.c(), w * s.d(), s.domain())?;
        Self::new(self.io, system)
    }

    /// What faults or noise do to the residual: `R = H_y G` (eq. 6), for any `G` into the outputs.
    ///
    /// The result has the states of `G` and of the form; for an unstable plant the unstable
    /// states cancel, but are still there.
    ///
    /// # Errors
    ///
    /// Returns an error when `G` has not one output per plant output.
    pub fn residual_of(&self, g: &StateSpace<D>) -> Result<StateSpace<D>, DesignError> {
        if g.ny() != self.io.ny {
            return Err(ShapeError {
                role: "feedthrough of G",
                expected: Shape::new(self.io.ny, g.nu()),
                found: Shape::new(g.ny(), g.nu()),
            }
            .into());
        }
        let hy = self.hy()?;
        let zero = Mat::zeros(g.nx(), hy.nx());
        // x_g⁺ = A_g x_g + B_g f; x_h⁺ = B_h C_g x_g + A_h x_h + B_h D_g f.
        let by = hy.b() * g.c();
        let a = blocks(&[&[g.a(), zero.as_ref()], &[by.as_ref(), hy.a()]]);
        let b = blocks(&[&[g.b()], &[(hy.b() * g.d()).as_ref()]]);
        let c = blocks(&[&[(hy.d() * g.c()).as_ref(), hy.c()]]);
        Ok(StateSpace::new(a, b, c, hy.d() * g.d(), hy.domain())?)
    }
}

impl<D: FrequencyAxis> ResidualForm<D> {
    /// `[H_u H_y]` at a frequency in rad/s, one row per residual channel.
    #[must_use]
    pub fn response(&self, omega: f64) -> Mat<c64> {
        response_of(&self.system, self.system.domain().boundary_point(omega))
    }

    /// `H_u` at a frequency in rad/s.
    #[must_use]
    pub fn hu_response(&self, omega: f64) -> Mat<c64> {
        self.response(omega).subcols(0, self.io.nu).to_owned()
    }

    /// `H_y` at a frequency in rad/s.
    #[must_use]
    pub fn hy_response(&self, omega: f64) -> Mat<c64> {
        self.response(omega).subcols(self.io.nu, self.io.ny).to_owned()
    }

    /// Largest `‖H_u + H_y G_u‖` over frequency (eq. 5), relative to `‖H_u‖ + ‖H_y‖ ‖G_u‖` there.
    ///
    /// Rounding leaves about `1e-12` for a well-conditioned generator of its own model; a value
    /// near one says that the generator belongs to another plant. Frequencies on a pole of the
    /// plant or of the form are skipped.
    ///
    /// # Errors
    ///
    /// Returns an error when the model has other channels than the form.
    pub fn consistency(&self, model: &StateSpace<D>) -> Result<f64, DesignError> {
        let (expected, found) =
            (Shape::new(self.io.ny, self.io.nu), Shape::new(model.ny(), model.nu()));
        if expected != found {
            return Err(ShapeError { role: "transfer function G_u", expected, found }.into());
        }
        let mut worst = 0.0_f64;
        for omega in frequency_grid(&[&self.system, model])? {
            let g = response_of(model, model.domain().boundary_point(omega));
            let (hu, hy) = (self.hu_response(omega), self.hy_response(omega));
            let scale = hu.norm_l2() + hy.norm_l2() * g.norm_l2();
            let defect = spectral_norm((hu + hy * g).as_ref());
            if scale.is_finite() && 0.0 < scale {
                worst = worst.max(defect / scale);
            }
        }
        Ok(worst)
    }
}
