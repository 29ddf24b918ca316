//! State equations that an estimator can ask at any state.

use std::{fmt::Debug, sync::Arc};

use fd_core::{IoDims, stage::Plant};
use fd_sim::simulate::StateMap;

/// `x⁺ = f(x, u)`, `y = h(x, u)` from sample to sample, with scratch space of its own.
///
/// Two things implement it: the [`StateMap`] of a model file, and any [`Plant`] in [`PlantEquations`].
/// A method that is asked twice with the same arguments gives the same bits, whatever was asked in
/// between; where the model is not valid it writes NaN. Neither allocates nor fails.
pub trait StateEquations: Debug + Send + Sync {
    /// Number of states.
    fn nx(&self) -> usize;

    /// Numbers of inputs and outputs.
    fn io(&self) -> IoDims;

    /// Writes the outputs at sample number `sample`.
    fn output(&mut self, sample: u64, x: &[f64], u: &[f64], y: &mut [f64]);

    /// Writes the state at the sample after `sample`. `u_next` are the inputs of that sample, for models
    /// that interpolate their inputs; others ignore them.
    fn advance(&mut self, sample: u64, x: &[f64], u: &[f64], u_next: &[f64], x_next: &mut [f64]);

    /// An independent copy.
    fn boxed(&self) -> Box<dyn StateEquations>;
}

impl Clone for Box<dyn StateEquations> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

impl StateEquations for Box<dyn StateEquations> {
    fn nx(&self) -> usize {
        (**self).nx()
    }

    fn io(&self) -> IoDims {
        (**self).io()
    }

    fn output(&mut self, sample: u64, x: &[f64], u: &[f64], y: &mut [f64]) {
        (**self).output(sample, x, u, y);
    }

    fn advance(&mut self, sample: u64, x: &[f64], u: &[f64], u_next: &[f64], x_next: &mut [f64]) {
        (**self).advance(sample, x, u, u_next, x_next);
    }

    fn boxed(&self) -> Box<dyn StateEquations> {
        (**self).boxed()
    }
}

impl StateEquations for StateMap {
    fn nx(&self) -> usize {
        self.states().len()
    }

    fn io(&self) -> IoDims {
        Self::io(self)
    }

    fn output(&mut self, sample: u64, x: &[f64], u: &[f64], y: &mut [f64]) {
        Self::output(self, sample, x, u, y);
    }

    fn advance(&mut self, sample: u64, x: &[f64], u: &[f64], u_next: &[f64], x_next: &mut [f64]) {
        Self::advance(self, sample, x, u, u_next, x_next);
    }

    fn boxed(&self) -> Box<dyn StateEquations> {
        Box::new(self.clone())
    }
}

/// The state equations of a [`Plant`]; copies share it.
///
/// ```
/// use faer::mat;
/// use fd_core::{Heap, IoDims};
/// use fd_model::{Discrete, Lti, SampleTime, StateSpace};
/// use fd_nonlinear::{PlantEquations, StateEquations};
///
/// let domain = Discrete { ts: SampleTime::new(0.1)? };
/// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
/// let mut equations = PlantEquations::new(lag.freeze::<f64, Heap>()?);
/// let mut next = [0.0];
/// equations.advance(0, &[2.0], &[0.25], &[0.0], &mut next);
/// assert_eq!((equations.nx(), next), (1, [1.25]));
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PlantEquations(Arc<dyn Plant<f64>>);

impl PlantEquations {
    /// The equations of `plant`.
    #[must_use]
    pub fn new(plant: impl Plant<f64> + 'static) -> Self {
        Self(Arc::new(plant))
    }
}

impl StateEquations for PlantEquations {
    fn nx(&self) -> usize {
        self.0.nx()
    }

    fn io(&self) -> IoDims {
        self.0.io()
    }

    fn output(&mut self, _sample: u64, x: &[f64], u: &[f64], y: &mut [f64]) {
        self.0.output(x, u, y);
    }

    fn advance(&mut self, _sample: u64, x: &[f64], u: &[f64], _next: &[f64], x_next: &mut [f64]) {
        self.0.advance(x, u, x_next);
    }

    fn boxed(&self) -> Box<dyn StateEquations> {
        Box::new(self.clone())
    }
}
