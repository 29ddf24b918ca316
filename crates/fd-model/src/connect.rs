//! Models out of models: series, parallel, feedback, side by side.

use faer::{Mat, MatRef, Scale};
use fd_core::{Shape, ShapeError};

use crate::{
    domain::TimeDomain,
    error::ModelError,
    linalg::{beside, diagonal, identity_minus, lower, solve, stack},
    state_space::StateSpace,
};

impl<D: TimeDomain> StateSpace<D> {
    /// A model without states: `y = K u`.
    ///
    /// # Errors
    ///
    /// Returns an error when the gain has a NaN or infinity.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// let gain = StateSpace::gain(mat![[3.0]], Continuous)?;
    /// assert_eq!((gain.nx(), gain.nu(), gain.ny()), (0, 1, 1));
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn gain(k: Mat<f64>, domain: D) -> Result<Self, ModelError> {
        let (ny, nu) = (k.nrows(), k.ncols());
        Self::new(Mat::zeros(0, 0), Mat::zeros(0, nu), Mat::zeros(ny, 0), k, domain)
    }

    /// This model followed by another: `G = G_next G_self`.
    ///
    /// # Errors
    ///
    /// Returns an error when the outputs do not fit the next inputs, or sample times differ.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// let lag = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// let twice = lag.series(&StateSpace::gain(mat![[2.0]], Continuous)?)?;
    /// assert_eq!(twice.dc_gain()?[(0, 0)], 2.0);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn series(&self, next: &Self) -> Result<Self, ModelError> {
        let domain = self.domain().join(next.domain())?;
        expect_gain("gain of the next model", next, next.ny(), self.ny())?;
        Self::new(
            lower(self.a(), (next.b() * self.c()).as_ref(), next.a()),
            stack(self.b(), (next.b() * self.d()).as_ref()),
            beside((next.d() * self.c()).as_ref(), next.c()),
            next.d() * self.d(),
            domain,
        )
    }

    /// Two models on the same inputs with added outputs: `G = G_self + G_other`.
    ///
    /// # Errors
    ///
    /// Returns an error when the numbers of inputs or outputs or the sample times differ.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// let lag = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// assert_eq!(lag.parallel(&lag)?.dc_gain()?[(0, 0)], 2.0);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn parallel(&self, other: &Self) -> Result<Self, ModelError> {
        self.sum(other, 1.0)
    }

    /// The error of a model that stands in for this one: `G = G_self − G_other`.
    ///
    /// # Errors
    ///
    /// Returns an error when the numbers of inputs or outputs or the sample times differ.
    pub fn difference(&self, other: &Self) -> Result<Self, ModelError> {
        self.sum(other, -1.0)
    }

    /// The closed loop with another model in negative feedback: `G = (I + G_self G_other)⁻¹ G_self`.
    ///
    /// # Errors
    ///
    /// Returns an error when sizes or sample times do not fit, or the loop is ill-posed because
    /// `I + D_self D_other` is singular.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// let lag = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// let closed = lag.feedback(&StateSpace::gain(mat![[3.0]], Continuous)?)?;
    /// assert_eq!(closed.a()[(0, 0)], -8.0);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn feedback(&self, other: &Self) -> Result<Self, ModelError> {
        let domain = self.domain().join(other.domain())?;
        expect_gain("gain in the feedback path", other, self.nu(), self.ny())?;
        let (a1, b1, c1, d1) = (self.a(), self.b(), self.c(), self.d());
        let (a2, b2, c2, d2) = (other.a(), other.b(), other.c(), other.d());

        // y = M (C₁x₁ − D₁C₂x₂ + D₁u) with M = (I + D₁D₂)⁻¹, and u₁ = u − C₂x₂ − D₂y.
        let loop_gain = d1 * d2;
        let minus = identity_minus(1.0, (-&loop_gain).as_ref());
        let free = beside(beside(c1, (-(d1 * c2)).as_ref()).as_ref(), d1);
        let y = solve("the algebraic loop I + D₁D₂", minus.as_ref(), free.as_ref())?;
        let (n1, n2, nu) = (self.nx(), other.nx(), self.nu());
        let from_x = y.subcols(0, n1 + n2);
        let from_u = y.subcols(n1 + n2, nu);
        let u1_x = beside(Mat::zeros(nu, n1).as_ref(), (-c2).as_ref()) - d2 * from_x;
        let u1_u = Mat::<f64>::identity(nu, nu) - d2 * from_u;
        let own = diagonal(a1, a2);
        Self::new(
            own + stack((b1 * u1_x).as_ref(), (b2 * from_x).as_ref()),
            stack((b1 * u1_u).as_ref(), (b2 * from_u).as_ref()),
            from_x.to_owned(),
            from_u.to_owned(),
            domain,
        )
    }

    /// Two models side by side with inputs and outputs of their own: `G = diag(G_self, G_other)`.
    ///
    /// # Errors
    ///
    /// Returns an error when the sample times differ.
    pub fn append(&self, other: &Self) -> Result<Self, ModelError> {
        let domain = self.domain().join(other.domain())?;
        Self::new(
            diagonal(self.a(), other.a()),
            diagonal(self.b(), other.b()),
            diagonal(self.c(), other.c()),
            diagonal(self.d(), other.d()),
            domain,
        )
    }

    fn sum(&self, other: &Self, sign: f64) -> Result<Self, ModelError> {
        let domain = self.domain().join(other.domain())?;
        expect_gain("gain of the other model", other, self.ny(), self.nu())?;
        let signed = |m: MatRef<'_, f64>| Scale(sign) * m;
        Self::new(
            diagonal(self.a(), other.a()),
            stack(self.b(), other.b()),
            beside(self.c(), signed(other.c()).as_ref()),
            self.d() + signed(other.d()),
            domain,
        )
    }
}

fn expect_gain<D: TimeDomain>(
    role: &'static str,
    model: &StateSpace<D>,
    ny: usize,
    nu: usize,
) -> Result<(), ModelError> {
    let (expected, found) = (Shape::new(ny, nu), Shape::new(model.ny(), model.nu()));
    if expected == found { Ok(()) } else { Err(ShapeError { role, expected, found }.into()) }
}
