//! Running a model beside the plant.

use fd_core::{
    Buffer, Frame, Heap, IoDims, Scalar, Shape, ShapeError, StateVisitor, Storage,
    stage::{Plant, ResidualGenerator, Stage},
};
use fd_model::Lti;

/// A simulated plant whose output is subtracted from the measured one.
///
/// The plant may be nonlinear. When its model leaves its region of validity it writes NaN, and
/// so does the residual from then on, until [`reset`](Stage::reset).
#[derive(Clone, Debug)]
pub struct Simulation<T: Scalar, S: Storage<T> = Heap, P = Lti<T, S>> {
    plant: P,
    start: S::X,
    x: S::X,
    x_next: S::X,
}

impl<T: Scalar, S: Storage<T>, P: Plant<T>> Simulation<T, S, P> {
    /// A generator that simulates `plant` from the state zero.
    ///
    /// # Errors
    ///
    /// Returns an error when the storage is fixed and has another number of states.
    ///
    /// # Examples
    ///
    /// A nonlinear tank, `x⁺ = x + 0.1 (u − √x)`, whose level is measured:
    ///
    /// ```
    /// use fd_core::{Fixed, Frame, IoDims, stage::{Plant, ResidualGenerator}};
    /// use fd_residual::simulation::Simulation;
    ///
    /// #[derive(Debug)]
    /// struct Tank;
    ///
    /// impl Plant for Tank {
    ///     fn nx(&self) -> usize { 1 }
    ///     fn io(&self) -> IoDims { IoDims { nu: 1, ny: 1 } }
    ///     fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
    ///         x_next[0] = x[0] + 0.1 * (u[0] - x[0].sqrt());
    ///     }
    ///     fn output(&self, x: &[f64], _u: &[f64], y: &mut [f64]) { y[0] = x[0]; }
    /// }
    ///
    /// let mut generator = Simulation::<f64, Fixed<1, 1, 1>, Tank>::new(Tank)?.starting_at(&[4.0])?;
    /// let mut r = [0.0];
    /// generator.step(Frame::new(generator.io(), 0, &[2.0], &[4.5])?, &mut r);
    /// assert_eq!(r, [0.5]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(plant: P) -> Result<Self, ShapeError> {
        let start = S::X::zeros("simulated state", plant.nx())?;
        Ok(Self { plant, x: start.clone(), x_next: start.clone(), start })
    }

    /// Sets the state from which the simulation starts, now and after every reset.
    ///
    /// # Errors
    ///
    /// Returns an error when the plant has another number of states.
    pub fn starting_at(mut self, state: &[T]) -> Result<Self, ShapeError> {
        let start = self.start.as_mut();
        if state.len() != start.len() {
            let expected = Shape::new(start.len(), 1);
            let found = Shape::new(state.len(), 1);
            return Err(ShapeError { role: "initial state", expected, found });
        }
        start.copy_from_slice(state);
        self.reset();
        Ok(self)
    }

    /// State of the simulated plant.
    #[must_use]
    pub fn state(&self) -> &[T] {
        self.x.as_ref()
    }

    /// State of the simulated plant, to be corrected by an observer.
    pub(crate) fn state_mut(&mut self) -> &mut [T] {
        self.x.as_mut()
    }
}

impl<T: Scalar, S: Storage<T>, P: Plant<T>> Stage<T> for Simulation<T, S, P> {
    fn reset(&mut self) {
        self.x.as_mut().copy_from_slice(self.start.as_ref());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("simulated state", self.x.as_mut());
    }
}

impl<T: Scalar, S: Storage<T>, P: Plant<T>> ResidualGenerator<T> for Simulation<T, S, P> {
    fn io(&self) -> IoDims {
        self.plant.io()
    }

    fn residual_len(&self) -> usize {
        self.plant.io().ny
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        self.plant.output(self.x.as_ref(), frame.u(), r);
        for (r, &y) in r.iter_mut().zip(frame.y()) {
            *r = y - *r;
        }
        self.plant.advance(self.x.as_ref(), frame.u(), self.x_next.as_mut());
        std::mem::swap(&mut self.x, &mut self.x_next);
    }
}
