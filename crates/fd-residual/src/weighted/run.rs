//! Running a weighting behind any generator.

use std::marker::PhantomData;

use fd_core::{
    Buffer, Frame, Heap, HeapMap, IoDims, LinMap, Scalar, Shape, ShapeError, StateVisitor, Storage,
    stage::{Plant, ResidualGenerator, Stage},
};
use fd_model::Lti;

/// The residual of `G`, multiplied by a matrix. `R` holds the inner residual.
#[derive(Clone, Debug)]
pub struct Weighted<T, G, W = HeapMap<T>, R = Vec<T>> {
    inner: G,
    weight: W,
    r: R,
    scalar: PhantomData<T>,
}

impl<T: Scalar, G: ResidualGenerator<T>, W: LinMap<T>, R: Buffer<T>> Weighted<T, G, W, R> {
    /// The residual `W r` of `inner`.
    ///
    /// # Errors
    ///
    /// Returns an error when the sizes do not fit.
    ///
    /// # Examples
    ///
    /// The paper's `W = [1 1 1 1 1]` without a heap:
    ///
    /// ```
    /// use fd_core::{Fixed, LinMap, Shape, Storage, stage::ResidualGenerator};
    /// use fd_residual::{observer::Observer, weighted::Weighted};
    ///
    /// type Row = <Fixed<5, 1, 1> as Storage<f32>>::Yx; // 1 × 5
    /// type Summed = Weighted<f32, Observer<f32, Fixed<5, 2, 5>>, Row, [f32; 5]>;
    ///
    /// fn sum_of(observer: Observer<f32, Fixed<5, 2, 5>>) -> Result<Summed, fd_core::ShapeError> {
    ///     Summed::new(observer, LinMap::from_fn("weighting W", Shape::new(1, 5), |_, _| 1.0)?)
    /// }
    /// ```
    pub fn new(inner: G, weight: W) -> Result<Self, ShapeError> {
        let found = weight.dims();
        let expected = Shape::new(found.rows, inner.residual_len());
        if found != expected {
            return Err(ShapeError { role: "weighting W", expected, found });
        }
        let r = R::zeros("inner residual", inner.residual_len())?;
        Ok(Self { inner, weight, r, scalar: PhantomData })
    }
}

impl<T, G, W, R> Stage<T> for Weighted<T, G, W, R>
where
    T: Scalar,
    G: ResidualGenerator<T>,
    W: LinMap<T>,
    R: Buffer<T>,
{
    fn reset(&mut self) {
        self.inner.reset();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.inner.visit_state(visitor);
    }
}

impl<T, G, W, R> ResidualGenerator<T> for Weighted<T, G, W, R>
where
    T: Scalar,
    G: ResidualGenerator<T>,
    W: LinMap<T>,
    R: Buffer<T>,
{
    fn io(&self) -> IoDims {
        self.inner.io()
    }

    fn residual_len(&self) -> usize {
        self.weight.dims().rows
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        self.inner.step(frame, self.r.as_mut());
        self.weight.mul_into(self.r.as_ref(), r);
    }
}

/// The residual of `G`, passed through a linear filter. `R` holds the inner residual; `S` has
/// the sizes filter states × inner residual × filtered residual.
#[derive(Clone, Debug)]
pub struct Filtered<T: Scalar, G, S: Storage<T> = Heap, R = Vec<T>> {
    inner: G,
    filter: Lti<T, S>,
    x: S::X,
    x_next: S::X,
    r: R,
}

impl<T: Scalar, G: ResidualGenerator<T>, S: Storage<T>, R: Buffer<T>> Filtered<T, G, S, R> {
    /// The residual `W(z) r` of `inner`, with the filter at rest at first.
    ///
    /// # Errors
    ///
    /// Returns an error when the sizes do not fit.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::{Fixed, stage::ResidualGenerator};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{simulation::Simulation, weighted::Filtered};
    ///
    /// type Size = Fixed<1, 1, 1>;
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.8]], mat![[0.2]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let inner = Simulation::<f32, Size>::new(lag.freeze()?)?;
    /// let smooth = Filtered::<f32, _, Size, [f32; 1]>::new(inner, lag.freeze()?)?;
    /// assert_eq!(smooth.residual_len(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(inner: G, filter: Lti<T, S>) -> Result<Self, ShapeError> {
        let IoDims { nu, ny } = filter.io();
        let (expected, found) = (Shape::new(ny, inner.residual_len()), Shape::new(ny, nu));
        if found != expected {
            return Err(ShapeError { role: "filter W(z)", expected, found });
        }
        let x = S::X::zeros("filter state", filter.nx())?;
        let r = R::zeros("inner residual", inner.residual_len())?;
        Ok(Self { inner, filter, x_next: x.clone(), x, r })
    }
}

impl<T, G, S, R> Stage<T> for Filtered<T, G, S, R>
where
    T: Scalar,
    G: ResidualGenerator<T>,
    S: Storage<T>,
    R: Buffer<T>,
{
    fn reset(&mut self) {
        self.inner.reset();
        self.x.as_mut().fill(T::zero());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.inner.visit_state(visitor);
        visitor.reals("filter state", self.x.as_mut());
    }
}

impl<T, G, S, R> ResidualGenerator<T> for Filtered<T, G, S, R>
where
    T: Scalar,
    G: ResidualGenerator<T>,
    S: Storage<T>,
    R: Buffer<T>,
{
    fn io(&self) -> IoDims {
        self.inner.io()
    }

    fn residual_len(&self) -> usize {
        self.filter.io().ny
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        self.inner.step(frame, self.r.as_mut());
        self.filter.output(self.x.as_ref(), self.r.as_ref(), r);
        self.filter.advance(self.x.as_ref(), self.r.as_ref(), self.x_next.as_mut());
        std::mem::swap(&mut self.x, &mut self.x_next);
        // A generator that begins anew, as a nonlinear one does where its model has no answer, finds the filter at rest.
        if self.r.as_ref().iter().any(|r| !r.is_finite()) {
            r.fill(T::from_design(f64::NAN));
            self.x.as_mut().fill(T::zero());
        }
    }
}
