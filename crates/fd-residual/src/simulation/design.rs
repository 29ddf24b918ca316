//! Checking that a model can stand beside its plant without feedback.

use faer::Mat;
use fd_core::{Heap, IoDims, Scalar, Storage, stage::ResidualGenerator};
use fd_model::{Discrete, Lti, ModelError, StateSpace, TimeDomain};

use super::run::Simulation;
use crate::{
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::blocks,
};

/// An open-loop simulation of a stable linear model.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_core::{Frame, Heap, stage::ResidualGenerator};
/// use fd_model::{Discrete, SampleTime, StateSpace};
/// use fd_residual::simulation::SimulationDesign;
///
/// let domain = Discrete { ts: SampleTime::new(0.1)? };
/// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
/// let mut generator = SimulationDesign::new(&lag)?.freeze::<f64, Heap>()?;
/// let mut r = [0.0];
/// for (k, (u, y)) in (0..).zip([([1.0], [0.0]), ([0.0], [1.0]), ([0.0], [0.75])]) {
///     generator.step(Frame::new(generator.io(), k, &u, &y)?, &mut r);
/// }
/// assert_eq!(r, [0.25]); // the third sample is off by a quarter
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SimulationDesign {
    model: StateSpace<Discrete>,
}

impl SimulationDesign {
    /// A generator from a stable model.
    ///
    /// # Errors
    ///
    /// Returns the worst pole when the model is unstable.
    pub fn new(model: &StateSpace<Discrete>) -> Result<Self, DesignError> {
        check_stable("an open-loop simulation residual", model)?;
        Ok(Self { model: model.clone() })
    }

    /// Moves the generator to run time, starting at `x = 0`; see [`Simulation::starting_at`].
    ///
    /// # Errors
    ///
    /// Returns an error when the storage is fixed and has other sizes.
    pub fn freeze<T: Scalar, S: Storage<T>>(
        &self,
    ) -> Result<Simulation<T, S, Lti<T, S>>, DesignError> {
        Ok(Simulation::new(self.model.freeze()?)?)
    }
}

impl GeneratorDesign for SimulationDesign {
    fn io(&self) -> IoDims {
        IoDims { nu: self.model.nu(), ny: self.model.ny() }
    }

    fn residual_len(&self) -> usize {
        self.model.ny()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        let m = &self.model;
        let (nx, ny) = (m.nx(), m.ny());
        let b = blocks(&[&[m.b(), Mat::zeros(nx, ny).as_ref()]]);
        let d = blocks(&[&[(-m.d()).as_ref(), Mat::identity(ny, ny).as_ref()]]);
        let system = StateSpace::new(m.a().to_owned(), b, -m.c(), d, m.domain())?;
        ResidualForm::new(self.io(), system)
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        Ok(Box::new(self.freeze::<f64, Heap>()?))
    }
}

/// Refuses a model with a mode that does not die out, and names the worst one.
pub(crate) fn check_stable<D: TimeDomain>(
    what: &'static str,
    model: &StateSpace<D>,
) -> Result<(), DesignError> {
    match model.worst_pole()?.filter(|&pole| !model.domain().decays(pole)) {
        Some(pole) => Err(ModelError::Unstable { what, re: pole.re, im: pole.im }.into()),
        None => Ok(()),
    }
}
