//! The realisation of `[H_u H_y]` and what can be asked of it.

use std::fmt::Debug;

use faer::{Mat, MatRef, c64};
use fd_core::{IoDims, Shape, ShapeError, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace, TimeDomain};

use super::frequency::frequency_grid;
use crate::{
    error::DesignError,
    matrix::{check_shape, spectral_norm},
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
        check_shape("weighting W", w, expected)?;
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
    /// Returns an error when `G` has not one output per plant output, or another sample time.
    pub fn residual_of(&self, g: &StateSpace<D>) -> Result<StateSpace<D>, DesignError> {
        Ok(g.series(&self.hy()?)?)
    }

    /// `H_u` and `H_y` at a frequency in rad/s, one row per residual channel.
    ///
    /// # Errors
    ///
    /// Returns an error when there is a pole at this frequency.
    pub fn response(&self, omega: f64) -> Result<(Mat<c64>, Mat<c64>), DesignError> {
        let both = self.system.frequency_response(omega)?;
        let IoDims { nu, ny } = self.io;
        Ok((both.subcols(0, nu).to_owned(), both.subcols(nu, ny).to_owned()))
    }

    /// Largest `‖H_u + H_y G_u‖` over frequency (eq. 5), relative to `‖H_u‖ + ‖H_y‖ ‖G_u‖` there.
    ///
    /// Rounding leaves about `1e-12` for a well-conditioned generator of its own model; a value
    /// near one says that the generator belongs to another plant. Frequencies on a pole of the
    /// plant or of the form are skipped.
    ///
    /// # Errors
    ///
    /// Returns an error when the model has other channels or another sample time than the form.
    pub fn consistency(&self, model: &StateSpace<D>) -> Result<f64, DesignError> {
        let (expected, found) =
            (Shape::new(self.io.ny, self.io.nu), Shape::new(model.ny(), model.nu()));
        if expected != found {
            return Err(ShapeError { role: "transfer function G_u", expected, found }.into());
        }
        self.system.domain().join(model.domain())?;
        let mut worst = 0.0_f64;
        for omega in frequency_grid(&[&self.system, model])? {
            let (Ok(g), Ok((hu, hy))) = (model.frequency_response(omega), self.response(omega))
            else {
                continue;
            };
            let scale = hu.norm_l2() + hy.norm_l2() * g.norm_l2();
            if 0.0 < scale {
                worst = worst.max(spectral_norm((hu + hy * g).as_ref()) / scale);
            }
        }
        Ok(worst)
    }
}
