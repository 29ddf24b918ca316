//! Invariant zeros: where a combination of inputs and states is hidden from all outputs.

use faer::{Mat, Scale, c64};

use crate::{
    domain::TimeDomain,
    error::ModelError,
    linalg::{balance, beside, compress_rows, generalised_eigenvalues, stack},
    state_space::StateSpace,
};

impl<D: TimeDomain> StateSpace<D> {
    /// Finite invariant zeros: the points `z` at which `[A − zI, B; C, D]` loses rank.
    ///
    /// For a controllable and observable model these are the transmission zeros; hidden modes
    /// appear as zeros too. Works for any numbers of inputs and outputs.
    ///
    /// A. Emami-Naeini and P. Van Dooren, "Computation of zeros of linear multivariable systems",
    /// Automatica 18(4), 1982: orthogonal transformations peel off all infinite zeros; the rest
    /// are generalised eigenvalues. Ranks are judged to rounding, after scaling of states, inputs,
    /// outputs and time.
    ///
    /// # Errors
    ///
    /// Returns an error when a decomposition does not converge.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// // (s + 3)/(s + 1) = 1 + 2/(s + 1)
    /// let lead = StateSpace::new(mat![[-1.0]], mat![[2.0]], mat![[1.0]], mat![[1.0]], Continuous)?;
    /// let zeros = lead.zeros()?;
    /// assert!(zeros.len() == 1 && (zeros[0].re + 3.0).abs() < 1e-14);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn zeros(&self) -> Result<Vec<c64>, ModelError> {
        if self.nx() == 0 {
            return Ok(Vec::new());
        }
        let scaling = balance(self.a(), self.b(), self.c());
        let a = scaling.a(self.a());
        // Zeros scale with time; ranks should not.
        let rate = a.norm_l2();
        let rate = if 0.0 < rate { rate } else { 1.0 };
        let system = System {
            a: Scale(rate.recip()) * a,
            b: Scale(rate.recip()) * scaling.b(self.b()),
            c: scaling.c(self.c()),
            d: self.d().to_owned(),
        };
        let system = system.with_unit_inputs().transposed().with_unit_inputs().transposed();
        let order = self.nx() + self.nu() + self.ny();
        let tolerance = 10.0 * order as f64 * f64::EPSILON * (order as f64).sqrt();
        let square = system.peel(tolerance)?.transposed().peel(tolerance)?.transposed();

        // [C D] N = 0 leaves the pencil [A B] N − z [I 0] N.
        let (n, m) = (square.a.nrows(), square.d.ncols());
        let outputs = beside(square.c.as_ref(), square.d.as_ref());
        let (basis, _) = compress_rows(outputs.transpose(), tolerance)?;
        let hidden = basis.subcols(m, n);
        let left = beside(square.a.as_ref(), square.b.as_ref()) * hidden;
        let zeros = generalised_eigenvalues(left.as_ref(), hidden.subrows(0, n))?;
        Ok(zeros.into_iter().map(|zero| zero * rate).collect())
    }
}

/// The system matrix `[A B; C D]` in parts.
struct System {
    a: Mat<f64>,
    b: Mat<f64>,
    c: Mat<f64>,
    d: Mat<f64>,
}

impl System {
    /// Scales inputs to unit size; those that do nothing stay as they are.
    fn with_unit_inputs(mut self) -> Self {
        for j in 0..self.d.ncols() {
            let size = self.b.col(j).norm_l2().hypot(self.d.col(j).norm_l2());
            if 0.0 < size {
                (0..self.b.nrows()).for_each(|i| self.b[(i, j)] /= size);
                (0..self.d.nrows()).for_each(|i| self.d[(i, j)] /= size);
            }
        }
        self
    }

    /// The dual system, with the same zeros.
    fn transposed(&self) -> Self {
        Self {
            a: self.a.transpose().to_owned(),
            b: self.c.transpose().to_owned(),
            c: self.b.transpose().to_owned(),
            d: self.d.transpose().to_owned(),
        }
    }

    /// A smaller system with the same finite zeros whose `D` has full row rank.
    ///
    /// Outputs that no input reaches directly force some states to zero; those states are taken
    /// out, and that they stay zero becomes a new output.
    fn peel(mut self, tolerance: f64) -> Result<Self, ModelError> {
        loop {
            let (rotation, rank) = compress_rows(self.d.as_ref(), tolerance)?;
            let c = rotation.transpose() * &self.c;
            let d = rotation.transpose() * &self.d;
            let (direct, unreached) = (c.subrows(0, rank), c.subrows(rank, c.nrows() - rank));
            let (basis, forced) = compress_rows(unreached.transpose(), tolerance)?;
            let d = d.subrows(0, rank);
            if forced == 0 {
                return Ok(Self { c: direct.to_owned(), d: d.to_owned(), ..self });
            }
            let a = basis.transpose() * &self.a * &basis;
            let b = basis.transpose() * &self.b;
            let c = direct * &basis;
            let free = a.nrows() - forced;
            self = Self {
                a: a.submatrix(forced, forced, free, free).to_owned(),
                b: b.subrows(forced, free).to_owned(),
                c: stack(c.subcols(forced, free), a.submatrix(0, forced, forced, free)),
                d: stack(d, b.subrows(0, forced)),
            };
        }
    }
}
