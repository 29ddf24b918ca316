//! Running the observer.

use fd_core::{
    Frame, Heap, IoDims, LinMap, Scalar, Shape, ShapeError, StateVisitor, Storage,
    stage::{Plant, ResidualGenerator, Stage},
};
use fd_model::Lti;

use crate::simulation::Simulation;

/// A simulated plant whose state is corrected by its own output error, which is the residual.
#[derive(Clone, Debug)]
pub struct Observer<T: Scalar, S: Storage<T> = Heap, P = Lti<T, S>> {
    simulation: Simulation<T, S, P>,
    gain: S::Xy,
}

impl<T: Scalar, S: Storage<T>, P: Plant<T>> Observer<T, S, P> {
    /// An observer of `plant` with gain `L` (states × outputs), starting at the state zero.
    ///
    /// The plant may be nonlinear; stability of the error is then the caller's business. For a
    /// linear model use [`ObserverDesign`](super::ObserverDesign), which checks it.
    ///
    /// # Errors
    ///
    /// Returns an error when the sizes do not fit.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::{Fixed, LinMap, Shape, Storage};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::observer::Observer;
    ///
    /// type Size = Fixed<1, 1, 1>;
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let gain = LinMap::from_fn("observer gain L", Shape::new(1, 1), |_, _| 0.4)?;
    /// let observer = Observer::<f32, Size>::new(lag.freeze()?, gain)?.starting_at(&[1.0])?;
    /// assert_eq!(observer.state(), [1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(plant: P, gain: S::Xy) -> Result<Self, ShapeError> {
        let expected = Shape::new(plant.nx(), plant.io().ny);
        let found = gain.dims();
        if found != expected {
            return Err(ShapeError { role: "observer gain L", expected, found });
        }
        Ok(Self { simulation: Simulation::new(plant)?, gain })
    }

    /// Sets the state from which the observer starts, now and after every reset.
    ///
    /// # Errors
    ///
    /// Returns an error when the plant has another number of states.
    pub fn starting_at(self, state: &[T]) -> Result<Self, ShapeError> {
        Ok(Self { simulation: self.simulation.starting_at(state)?, gain: self.gain })
    }

    /// Estimate of the state at the next sample, from all samples so far.
    #[must_use]
    pub fn state(&self) -> &[T] {
        self.simulation.state()
    }
}

impl<T: Scalar, S: Storage<T>, P: Plant<T>> Stage<T> for Observer<T, S, P> {
    fn reset(&mut self) {
        self.simulation.reset();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.simulation.visit_state(visitor);
    }
}

impl<T: Scalar, S: Storage<T>, P: Plant<T>> ResidualGenerator<T> for Observer<T, S, P> {
    fn io(&self) -> IoDims {
        self.simulation.io()
    }

    fn residual_len(&self) -> usize {
        self.simulation.residual_len()
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        // r = y − h(x̂, u), then x̂⁺ = f(x̂, u) + L r.
        self.simulation.step(frame, r);
        self.gain.mul_add_into(r, self.simulation.state_mut());
    }
}
