//! Some channels of a model, models beside and above each other, and what of them is minimal.

use faer::{Mat, MatRef};
use fd_core::{Shape, ShapeError};

use crate::{
    domain::TimeDomain,
    error::ModelError,
    linalg::{beside, diagonal, stack, svd},
    state_space::StateSpace,
};

impl<D: TimeDomain> StateSpace<D> {
    /// The model between some of its channels, in the given order; one may be named twice.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such channel.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// let (a, c) = (mat![[-1.0, 0.0], [1.0, -2.0]], Mat::identity(2, 2));
    /// let tanks = StateSpace::new(a, mat![[1.0, 0.0], [0.0, 1.0]], c, Mat::zeros(2, 2), Continuous)?;
    /// let one = tanks.select(&[1], &[0])?; // 1/((s + 1)(s + 2))
    /// assert_eq!(one.dc_gain()?, mat![[0.5]]);
    /// assert!(tanks.select(&[2], &[0]).is_err());
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn select(&self, outputs: &[usize], inputs: &[usize]) -> Result<Self, ModelError> {
        for (what, chosen, count) in
            [("outputs", outputs, self.ny()), ("inputs", inputs, self.nu())]
        {
            if let Some(&index) = chosen.iter().find(|&&index| count <= index) {
                return Err(ModelError::Order { requested: index, available: count, what });
            }
        }
        let (b, c, d) = (self.b(), self.c(), self.d());
        Self::new(
            self.a().to_owned(),
            Mat::from_fn(self.nx(), inputs.len(), |i, j| b[(i, inputs[j])]),
            Mat::from_fn(outputs.len(), self.nx(), |i, j| c[(outputs[i], j)]),
            Mat::from_fn(outputs.len(), inputs.len(), |i, j| d[(outputs[i], inputs[j])]),
            self.domain(),
        )
    }

    /// Two models with inputs of their own and the sum of their outputs: `G = [G_self G_other]`.
    ///
    /// # Errors
    ///
    /// Returns an error when the numbers of outputs or the sample times differ.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// let lag = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// let both = lag.beside(&StateSpace::gain(mat![[3.0]], Continuous)?)?;
    /// assert_eq!(both.dc_gain()?, mat![[1.0, 3.0]]);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn beside(&self, other: &Self) -> Result<Self, ModelError> {
        let domain = self.domain().join(other.domain())?;
        let (expected, found) =
            (Shape::new(self.ny(), other.nu()), Shape::new(other.ny(), other.nu()));
        if expected != found {
            return Err(ShapeError { role: "gain of the model beside", expected, found }.into());
        }
        Self::new(
            diagonal(self.a(), other.a()),
            diagonal(self.b(), other.b()),
            beside(self.c(), other.c()),
            beside(self.d(), other.d()),
            domain,
        )
    }

    /// Two models on the same inputs, one above the other: `G = [G_self; G_other]`.
    ///
    /// # Errors
    ///
    /// Returns an error when the numbers of inputs or the sample times differ.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// let lag = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// let both = lag.above(&StateSpace::gain(mat![[3.0]], Continuous)?)?;
    /// assert_eq!(both.dc_gain()?, mat![[1.0], [3.0]]);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn above(&self, other: &Self) -> Result<Self, ModelError> {
        let domain = self.domain().join(other.domain())?;
        let (expected, found) =
            (Shape::new(other.ny(), self.nu()), Shape::new(other.ny(), other.nu()));
        if expected != found {
            return Err(ShapeError { role: "gain of the model below", expected, found }.into());
        }
        Self::new(
            diagonal(self.a(), other.a()),
            stack(self.b(), other.b()),
            diagonal(self.c(), other.c()),
            stack(self.d(), other.d()),
            domain,
        )
    }

    /// The same transfer function with only those states that the inputs move and the outputs show.
    ///
    /// By staircases of orthogonal transformations (Rosenbrock 1970), in
    /// [natural units](Self::natural_units); it works for unstable models, for which
    /// [`balanced_truncation`](crate::reduce::balanced_truncation) does not. A direction is new when it is
    /// larger than `tolerance` relative to the model.
    ///
    /// # Errors
    ///
    /// Returns an error when a decomposition does not converge, or the tolerance is not within `(0, 1)`.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// // Of two copies of an unstable mode one is enough.
    /// let a = mat![[1.0, 0.0], [0.0, 1.0]];
    /// let both = StateSpace::new(a, mat![[1.0], [2.0]], mat![[1.0, 1.0]], mat![[0.0]], Continuous)?;
    /// let one = both.minimal(1e-10)?;
    /// assert_eq!(one.nx(), 1);
    /// assert!((one.dc_gain()?[(0, 0)] + 3.0).abs() < 1e-12);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn minimal(&self, tolerance: f64) -> Result<Self, ModelError> {
        if !(0.0 < tolerance && tolerance < 1.0) {
            let role = "the relative tolerance of a minimal realisation";
            return Err(ModelError::OutOfRange { role, range: "(0, 1)", value: tolerance });
        }
        let units = self.natural_units();
        let natural = self.in_units(&units)?;
        let part = natural.within(&reachable(natural.a(), natural.b(), tolerance)?)?;
        let seen = reachable(part.a().transpose(), part.c().transpose(), tolerance)?;
        let part = part.within(&seen)?;
        let (b, c, order) = (part.b(), part.c(), part.nx());
        Self::new(
            part.a().to_owned(),
            Mat::from_fn(order, self.nu(), |i, j| b[(i, j)] / units.inputs[j]),
            Mat::from_fn(self.ny(), order, |i, j| c[(i, j)] * units.outputs[i]),
            self.d().to_owned(),
            self.domain(),
        )
    }

    /// The part of the model in an invariant subspace with orthonormal columns.
    fn within(&self, onto: &Mat<f64>) -> Result<Self, ModelError> {
        Self::new(
            onto.transpose() * self.a() * onto,
            onto.transpose() * self.b(),
            self.c() * onto,
            self.d().to_owned(),
            self.domain(),
        )
    }
}

/// Orthonormal columns that span what `B` reaches through `A`.
fn reachable(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    tolerance: f64,
) -> Result<Mat<f64>, ModelError> {
    let n = a.nrows();
    let mut found = Mat::<f64>::zeros(n, 0);
    let (mut newest, mut size) = (b.to_owned(), b.norm_l2());
    while found.ncols() < n && 0 < newest.ncols() {
        // Twice is enough: what a second projection removes is rounding of the first.
        for _ in 0..2 {
            newest = &newest - &found * (found.transpose() * &newest);
        }
        let parts = svd(newest.as_ref())?;
        let grown = parts.values.iter().filter(|&&s| tolerance * size < s).count();
        let fresh = parts.u.subcols(0, grown).to_owned();
        found = beside(found.as_ref(), fresh.as_ref());
        newest = a * fresh;
        size = a.norm_l2();
    }
    Ok(found)
}
