//! The realisation of `[H_u H_y]`, and the analysis of it.

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
/// A design works in `f64` with matrices, may fail and may take a second. What runs is a [`ResidualGenerator`],
/// which works on slices and does none of that. This trait is the design side of every linear generator,
/// whatever its method. It gives two things: what the residual *is* ([`form`](Self::form)), and how to run it
/// ([`build`](Self::build)).
///
/// # The contract
///
/// * [`form`](Self::form) defines the residual: the transfer functions from `u` and `y` to `r`, as one
///   realisation. All analysis is done on it. If the form differs from what runs, every answer about
///   detectability is wrong, so the shared tests of this crate compare the two sample by sample.
/// * `H_u + H_y G_u = 0` (Patton and Chen 1992, eq. 5) for the model that the design was made for:
///   [`ResidualForm::consistency`] is of the order of rounding, about `1e-12`. In a generator that fails this
///   the input shows in the residual, and no threshold can correct that.
/// * The form is stable; otherwise the residual would drift.
/// * [`build`](Self::build) returns a new generator each time, in its initial state, with no link to the design
///   or to other generators built from it.
/// * `io` and `residual_len` are the same for the design, its form and what it builds.
///
/// A design is a value. It does not change after its constructor has returned, so everything that can go wrong
/// goes wrong in the constructor, which says why: [`DesignError`] names what the model did not allow (no output
/// left after decoupling, an unstable zero, a fault that is not detectable).
///
/// # Who calls it, and when
///
/// Training asks for a design once, takes the form for the settling time and the signatures of faults,
/// builds one generator per pipeline, and keeps the design for reports. `fdiag::fleet` takes the form
/// alone. A bank holds designs as boxes and joins their forms. Nothing here is called per sample.
///
/// # What an implementor must and must not do
///
/// * *Check in the constructor*, and return a typed error; `form` and `build` then cannot fail in practice, and
///   their `Result` is for inner parts from other crates.
/// * *Do not scale.* The design determines the unit of the residual; normalising it is the task of the
///   detector.
/// * *Do not hold run-time state.* There is no "current" residual in a design.
/// * *Offer `freeze::<T, S>()`* beside `build` where `f32` or sizes known to the compiler are wanted.
///   It cannot be part of the trait, which works as `dyn`.
///
/// # How it composes
///
/// * `Box<dyn GeneratorDesign>` is a design; [`BankDesign`](crate::bank::BankDesign) puts several side
///   by side.
/// * [`WeightedDesign`](crate::weighted::WeightedDesign) and
///   [`FilteredDesign`](crate::weighted::FilteredDesign) take any design and are designs.
/// * In a spec, a line `kind = "…"` creates a box of a built-in design. A design of your own is added to a bank
///   or a pipeline from outside, see `examples/own_generator.rs`.
/// * List it in `fd_residual::testing`, and all shared tests of this crate cover it.
///
/// # When not to implement it
///
/// For a nonlinear generator, which has no form. Implement [`ResidualGenerator`] alone; it runs in every
/// pipeline, but cannot be analysed in advance. A generator that learns while it runs may implement both, if
/// its form describes its initial behaviour ([`AdaptiveDesign`](crate::adaptive::AdaptiveDesign) does).
///
/// For matrices that were designed elsewhere, [`ResidualForm`] is itself a design.
///
/// # Example
///
/// A mass balance: since the last sample a tenth of the contents of a tank has drained, and the inflow has been
/// added, `r(k) = y(k) − 0.9 y(k−1) − 5 u(k−1)`. There are no poles to place and no initial state to forget.
/// Writing down the form is enough; the generator that runs it comes with it:
///
/// ```
/// use faer::{Mat, mat};
/// use fd_core::{Frame, Heap, IoDims, stage::ResidualGenerator};
/// use fd_model::{Discrete, SampleTime, StateSpace};
/// use fd_residual::{
///     DesignError, GeneratorDesign, ResidualForm,
///     analysis::{UnknownInputs, fault_effects},
/// };
///
/// #[derive(Debug)]
/// struct MassBalance {
///     form: ResidualForm,
/// }
///
/// impl MassBalance {
///     /// For a tank that keeps the share `kept` of its level and gains `gain` m per m³/s of inflow.
///     fn new(kept: f64, gain: f64, domain: Discrete) -> Result<Self, DesignError> {
///         // The states are the last inflow and the last level.
///         let (last, c) = (Mat::identity(2, 2), mat![[-gain, -kept]]);
///         let system = StateSpace::new(Mat::zeros(2, 2), last, c, mat![[0.0, 1.0]], domain)?;
///         Ok(Self { form: ResidualForm::new(IoDims { nu: 1, ny: 1 }, system)? })
///     }
/// }
///
/// impl GeneratorDesign for MassBalance {
///     fn io(&self) -> IoDims {
///         self.form.io()
///     }
///
///     fn residual_len(&self) -> usize {
///         self.form.residual_len()
///     }
///
///     fn form(&self) -> Result<ResidualForm, DesignError> {
///         Ok(self.form.clone())
///     }
///
///     fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
///         Ok(Box::new(self.form.freeze::<f64, Heap, Heap>()?))
///     }
/// }
///
/// let domain = Discrete { ts: SampleTime::new(10.0)? };
/// let tank = StateSpace::new(mat![[0.9]], mat![[5.0]], mat![[1.0]], mat![[0.0]], domain)?;
/// let balance = MassBalance::new(0.9, 5.0, domain)?;
/// assert!(balance.form()?.consistency(&tank)? < 1e-12);
///
/// // Before a sample is run: what will it show? A leak in full, of a wrong level only a tenth.
/// let faults = UnknownInputs::none(&tank).actuator(&tank, 0)?.sensor(&tank, 0)?;
/// let effects = fault_effects(&balance.form()?, &faults.system(&tank)?)?;
/// let steady = |fault: usize| effects[fault].steady.unwrap_or(f64::NAN);
/// assert!((steady(0) - 5.0).abs() < 1e-12 && (steady(1) - 0.1).abs() < 1e-12);
///
/// // And so it does: from sample 5 on a leak takes 0.01 m³/s, in each sample 0.05 m of level.
/// let (mut generator, mut level, mut r) = (balance.build()?, 1.0, [0.0]);
/// for k in 0..20 {
///     generator.step(Frame::new(generator.io(), k, &[0.1], &[level])?, &mut r);
///     level = 0.9 * level + 5.0 * (0.1 - if k < 5 { 0.0 } else { 0.01 });
/// }
/// assert!((r[0] + 0.05).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
