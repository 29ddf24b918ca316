//! Choosing the parity vectors.

use faer::{Mat, MatRef};
use fd_core::{Heap, IoDims, Scalar, Shape, stage::ResidualGenerator};
use fd_model::{Discrete, ModelError, StateSpace, TimeDomain, freeze};
use fd_numeric::dense::Dense;

use super::{
    natural::NaturalPlant,
    run::{Parity, Window},
    window::{input_map, observability},
};
use crate::{
    analysis::UnknownInputs,
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::{blocks, check_shape},
    rank::{RankDecision, RankTolerance},
};

/// Largest relative part of the state that a given vector may let through.
const TOLERANCE: f64 = 1e-10;

/// Parity vectors `W` (rows) over `s + 1` samples, oldest sample first.
#[derive(Clone, Debug)]
pub struct ParityDesign {
    io: IoDims,
    order: usize,
    domain: Discrete,
    from_y: Mat<f64>,
    from_u: Mat<f64>,
    leak: Vec<f64>,
    rank: Option<RankDecision>,
}

impl ParityDesign {
    /// All parity vectors of order `s`: a basis of the left null space of `Γ`.
    ///
    /// How many there are is decided in [natural units](StateSpace::natural_units); the vectors
    /// themselves are orthonormal in those of the model.
    ///
    /// # Errors
    ///
    /// Returns the rank decision when the window is too short for any.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::parity::ParityDesign;
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let design = ParityDesign::all(&lag, 1)?; // y(k) − 0.5 y(k−1) − u(k−1) up to a factor
    /// assert_eq!(design.vectors().nrows(), 1);
    /// assert!((design.vectors()[(0, 0)] / design.vectors()[(0, 1)] + 0.5).abs() < 1e-15);
    /// assert!(ParityDesign::all(&lag, 0).is_err());
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn all(model: &StateSpace<Discrete>, order: usize) -> Result<Self, DesignError> {
        Self::decoupled(model, order, &UnknownInputs::none(model))
    }

    /// All parity vectors of order `s` that also ignore `unknown` inputs.
    ///
    /// # Errors
    ///
    /// Returns the rank decision when there are none, or an error when the unknown inputs were
    /// made for a model of other sizes.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{analysis::UnknownInputs, parity::ParityDesign};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let (b, c) = (mat![[1.0]], mat![[1.0], [2.0]]);
    /// let lag = StateSpace::new(mat![[0.9]], b, c, Mat::zeros(2, 1), domain)?;
    /// let load = UnknownInputs::none(&lag).component("load", &[1.0], &[0.0, 0.0])?;
    /// let design = ParityDesign::decoupled(&lag, 0, &load)?; // 2 y₁ − y₂, up to a factor
    /// assert!((design.vectors()[(0, 0)] / design.vectors()[(0, 1)] + 2.0).abs() < 1e-14);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn decoupled(
        model: &StateSpace<Discrete>,
        order: usize,
        unknown: &UnknownInputs,
    ) -> Result<Self, DesignError> {
        Self::decoupled_within(model, order, unknown, RankTolerance::default())
    }

    /// The same for a model that is known to a given tolerance.
    ///
    /// # Errors
    ///
    /// As [`decoupled`](Self::decoupled).
    pub fn decoupled_within(
        model: &StateSpace<Discrete>,
        order: usize,
        unknown: &UnknownInputs,
        tolerance: RankTolerance,
    ) -> Result<Self, DesignError> {
        let plant = NaturalPlant::of(model, unknown)?;
        let all: Vec<_> = (0..unknown.len()).collect();
        let decided = plant.window(order).decoupled_from(&all, tolerance)?;
        let (w, rank) = (decided.annihilators(), decided.decision);
        if w.nrows() == 0 {
            let RankDecision { rank, rows, smallest_kept: smallest, .. } = rank;
            return Err(DesignError::NoParity { order, rank, rows, smallest });
        }
        Ok(Self::unchecked(model, order, plant.in_model_units(w.as_ref()), Some(rank)))
    }

    /// Given parity vectors, one per row, over `order + 1` samples.
    ///
    /// # Errors
    ///
    /// Returns an error when the width is wrong or a vector does not annihilate `Γ`.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::parity::ParityDesign;
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// assert!(ParityDesign::with_vectors(&lag, 1, mat![[-0.5, 1.0]].as_ref()).is_ok());
    /// assert!(ParityDesign::with_vectors(&lag, 1, mat![[-0.6, 1.0]].as_ref()).is_err());
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn with_vectors(
        model: &StateSpace<Discrete>,
        order: usize,
        w: MatRef<'_, f64>,
    ) -> Result<Self, DesignError> {
        if w.nrows() == 0 {
            return Err(DesignError::Empty { what: "parity vector" });
        }
        check_shape("parity matrix W", w, Shape::new(w.nrows(), (order + 1) * model.ny()))?;
        let design = Self::unchecked(model, order, w.to_owned(), None);
        match design.leak.iter().position(|&leak| TOLERANCE < leak) {
            Some(row) => Err(DesignError::NotParity { row, residue: design.leak[row] }),
            None => Ok(design),
        }
    }

    /// The `count` vectors that are closest to orthogonal to the observability matrices of
    /// several models at once, best first (Lou, Willsky and Verghese 1986).
    ///
    /// The models are values that the plant may take; the first is the nominal one, whose
    /// Markov parameters take the inputs out. With one model and a window that is long enough
    /// the vectors are exact; otherwise [`leak`](Self::leak) says how much of the state passes.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no model, their channels or sample times differ, or
    /// `count` is zero or more than the window has rows.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::parity::ParityDesign;
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = |a: f64| StateSpace::new(mat![[a]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain);
    /// let design = ParityDesign::closest(&[lag(0.5)?, lag(0.52)?], 1, 1)?;
    /// assert!(1e-4 < design.leak()[0] && design.leak()[0] < 0.02);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn closest(
        models: &[StateSpace<Discrete>],
        order: usize,
        count: usize,
    ) -> Result<Self, DesignError> {
        let Some(nominal) = models.first() else {
            return Err(DesignError::Empty { what: "model" });
        };
        let rows = (order + 1) * nominal.ny();
        if count == 0 {
            return Err(DesignError::Empty { what: "parity vector" });
        }
        if rows < count {
            return Err(DesignError::Index {
                what: "parity vector",
                index: count - 1,
                count: rows,
            });
        }
        let mut all = Mat::zeros(rows, 0);
        for model in models {
            nominal.domain().join(model.domain())?;
            check_shape("feedthrough D", model.d(), Shape::new(nominal.ny(), nominal.nu()))?;
            let gamma = observability(model.a(), model.c(), order);
            all = blocks(&[&[all.as_ref(), gamma.as_ref()]]);
        }
        let svd = all
            .full_svd()
            .map_err(|_| ModelError::NoConvergence { what: "parity vectors", order: rows })?;
        let best_first = Mat::from_fn(count, rows, |i, j| svd.U()[(j, rows - 1 - i)]);
        let mut design = Self::unchecked(nominal, order, best_first, None);
        // Leak over all models: ‖w [Γ₁ … Γ_N]‖ is the singular value itself.
        for (i, leak) in design.leak.iter_mut().enumerate() {
            let sigma = |k: usize| if k < all.ncols() { svd.S()[k] } else { 0.0 };
            *leak = if sigma(0) > 0.0 { sigma(rows - 1 - i) / sigma(0) } else { 0.0 };
        }
        Ok(design)
    }

    /// Keeps some of the vectors, in the given order.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no index, or one that does not exist.
    pub fn select(&self, vectors: &[usize]) -> Result<Self, DesignError> {
        if vectors.is_empty() {
            return Err(DesignError::Empty { what: "parity vector" });
        }
        let count = self.from_y.nrows();
        if let Some(&index) = vectors.iter().find(|&&i| count <= i) {
            return Err(DesignError::Index { what: "parity vector", index, count });
        }
        let pick = |m: &Mat<f64>| Mat::from_fn(vectors.len(), m.ncols(), |i, j| m[(vectors[i], j)]);
        Ok(Self {
            from_y: pick(&self.from_y),
            from_u: pick(&self.from_u),
            leak: vectors.iter().map(|&i| self.leak[i]).collect(),
            ..self.clone()
        })
    }

    /// Combinations of a window that are not to be exact for any model.
    pub(crate) fn given(
        io: IoDims,
        order: usize,
        domain: Discrete,
        from_y: Mat<f64>,
        from_u: Mat<f64>,
    ) -> Self {
        let leak = vec![f64::NAN; from_y.nrows()];
        Self { io, order, domain, from_y, from_u, leak, rank: None }
    }

    /// Vectors that were not checked against `Γ`, with what they let through.
    pub(super) fn unchecked(
        model: &StateSpace<Discrete>,
        order: usize,
        w: Mat<f64>,
        rank: Option<RankDecision>,
    ) -> Self {
        let gamma = observability(model.a(), model.c(), order);
        let t = input_map(model.a(), model.b(), model.c(), model.d(), order);
        let through = &w * &gamma;
        let leak = |i: usize| {
            let scale = w.row(i).norm_l2() * gamma.norm_l2();
            if scale > 0.0 { through.row(i).norm_l2() / scale } else { 0.0 }
        };
        Self {
            io: IoDims { nu: model.nu(), ny: model.ny() },
            order,
            domain: model.domain(),
            leak: (0..w.nrows()).map(leak).collect(),
            from_u: -(&w * t),
            from_y: w,
            rank,
        }
    }

    /// The parity vectors `W`, one per row.
    #[must_use]
    pub fn vectors(&self) -> MatRef<'_, f64> {
        self.from_y.as_ref()
    }

    /// Window length minus one.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// Part of the initial state that passes each vector: `‖w Γ‖ / (‖w‖ ‖Γ‖)`, rounding only for
    /// exact vectors.
    #[must_use]
    pub fn leak(&self) -> &[f64] {
        &self.leak
    }

    /// How the number of exact vectors was decided; `None` for given or closest ones.
    #[must_use]
    pub fn rank(&self) -> Option<RankDecision> {
        self.rank
    }

    /// Moves the vectors to run time.
    ///
    /// # Errors
    ///
    /// Returns an error when the storage is fixed and has other sizes.
    pub fn freeze<T: Scalar, S: Window<T>>(&self) -> Result<Parity<T, S>, DesignError> {
        let from_y = freeze("parity matrix W", self.from_y.as_ref())?;
        let from_u = freeze("parity matrix −W T", self.from_u.as_ref())?;
        Ok(Parity::new(self.io, self.order, from_y, from_u)?)
    }
}

impl GeneratorDesign for ParityDesign {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        self.from_y.nrows()
    }

    /// A shift register of the last `s` samples of `[u; y]`, oldest first.
    fn form(&self) -> Result<ResidualForm, DesignError> {
        let IoDims { nu, ny } = self.io;
        let width = nu + ny;
        let nx = self.order * width;
        let shift = Mat::from_fn(nx, nx, |i, j| if i + width == j { 1.0 } else { 0.0 });
        let enter = Mat::from_fn(nx, width, |i, j| if i + width == nx + j { 1.0 } else { 0.0 });
        let weight = |i: usize, sample: usize, j: usize| {
            if j < nu {
                self.from_u[(i, sample * nu + j)]
            } else {
                self.from_y[(i, sample * ny + j - nu)]
            }
        };
        let rows = self.residual_len();
        let c = Mat::from_fn(rows, nx, |i, j| weight(i, j / width, j % width));
        let d = Mat::from_fn(rows, width, |i, j| weight(i, self.order, j));
        ResidualForm::new(self.io, StateSpace::new(shift, enter, c, d, self.domain)?)
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        Ok(Box::new(self.freeze::<f64, Heap>()?))
    }
}
