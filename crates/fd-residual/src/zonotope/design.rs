//! What is bounded, and by how much.

use faer::{Mat, MatRef};
use fd_core::{Frame, IoDims, Scalar, Shape, stage::ResidualGenerator};
use fd_model::{Discrete, ModelError, StateSpace, freeze};

use super::{
    run::{Parts, ZonotopeObserver},
    set::Zonotope,
};
use crate::{
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::check_shape,
    observer::ObserverDesign,
    weighted::WeightedDesign,
};

/// Columns for which nobody has the memory, let alone the time.
const MOST_COLUMNS: usize = 100_000;
/// Samples after which a set that still grows is said to have no bound.
const LONGEST: usize = 20_000;
/// Relative change over a tenth of the samples so far below which a set no longer grows.
const SETTLED: f64 = 1e-6;

/// How far each entry of the model may be off, in the unit of the entry: matrices without negative entries, of the
/// sizes of `A`, `B`, `C` and `D`.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelBounds {
    /// Of `A`.
    pub a: Mat<f64>,
    /// Of `B`.
    pub b: Mat<f64>,
    /// Of `C`.
    pub c: Mat<f64>,
    /// Of `D`.
    pub d: Mat<f64>,
}

impl ModelBounds {
    /// A model that is exactly right.
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::zonotope::ModelBounds;
    ///
    /// let domain = Discrete { ts: SampleTime::new(1.0)? };
    /// let lag = StateSpace::new(mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// assert_eq!(ModelBounds::exact(&lag).a[(0, 0)], 0.0);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    #[must_use]
    pub fn exact(model: &StateSpace<Discrete>) -> Self {
        let like = |m: MatRef<'_, f64>| Mat::zeros(m.nrows(), m.ncols());
        Self { a: like(model.a()), b: like(model.b()), c: like(model.c()), d: like(model.d()) }
    }

    fn each(&self) -> [(&'static str, MatRef<'_, f64>); 4] {
        [
            ("bound of A", self.a.as_ref()),
            ("bound of B", self.b.as_ref()),
            ("bound of C", self.c.as_ref()),
            ("bound of D", self.d.as_ref()),
        ]
    }
}

/// Everything that is unknown, and how large it can be.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// `E` (states × disturbances): what a disturbance between −1 and 1 adds to the next state.
    pub disturbance: Mat<f64>,
    /// Largest noise of each output, above zero, in its unit.
    pub noise: Vec<f64>,
    /// Largest distance of each state from zero before the first sample; without it, what the set settles to.
    pub initial: Option<Vec<f64>>,
    /// The model.
    pub model: ModelBounds,
}

/// An observer with bounds.
#[derive(Clone, Debug)]
pub struct ZonotopeDesign {
    observer: ObserverDesign,
    bounds: Bounds,
    columns: usize,
    start: Vec<f64>,
    /// Half widths of the outputs at rest, after a long time.
    settled: Vec<f64>,
}

impl ZonotopeDesign {
    /// The set around an observer, with at most `columns` columns between samples (twice the number of states is
    /// coarse, ten times is fine).
    ///
    /// # Errors
    ///
    /// Returns an error when a size does not fit, a bound is negative (that of the noise: not above zero) or not
    /// finite, there are fewer columns than states, or the set grows without end: too much of the model is uncertain
    /// for this gain and this number of columns.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::{Frame, stage::ResidualGenerator};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{observer::ObserverDesign, zonotope::{Bounds, ModelBounds, ZonotopeDesign}};
    ///
    /// let domain = Discrete { ts: SampleTime::new(1.0)? };
    /// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let observer = ObserverDesign::with_gain(&lag, mat![[0.0]].as_ref())?;
    /// let bounds = Bounds {
    ///     disturbance: mat![[0.1]],
    ///     noise: vec![0.3],
    ///     initial: None,
    ///     model: ModelBounds::exact(&lag),
    /// };
    /// let design = ZonotopeDesign::new(observer, bounds, 8)?;
    /// // 0.1 (1 + 0.5 + 0.25 + …) + 0.3
    /// assert!((design.settled()[0] - 0.5).abs() < 1e-6);
    /// let (mut running, mut r) = (design.freeze::<f64>()?, [0.0]);
    /// running.step(Frame::new(running.io(), 0, &[0.0], &[0.6])?, &mut r);
    /// assert!(1.0 < r[0]); // no disturbance within its bound explains this
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        observer: ObserverDesign,
        bounds: Bounds,
        columns: usize,
    ) -> Result<Self, DesignError> {
        let m = observer.model();
        let (nx, ny) = (m.nx(), m.ny());
        check_shape(
            "disturbance E",
            bounds.disturbance.as_ref(),
            Shape::new(nx, bounds.disturbance.ncols()),
        )?;
        let shapes = [m.a(), m.b(), m.c(), m.d()].map(|m| Shape::new(m.nrows(), m.ncols()));
        for ((role, bound), shape) in bounds.model.each().into_iter().zip(shapes) {
            check_shape(role, bound, shape)?;
            let mut entries =
                (0..bound.ncols()).flat_map(|j| (0..bound.nrows()).map(move |i| bound[(i, j)]));
            if let Some(value) = entries.find(|v| *v < 0.0) {
                return Err(ModelError::OutOfRange { role, range: "[0, inf)", value }.into());
            }
        }
        if bounds.noise.len() != ny {
            return Err(DesignError::Count {
                what: "bounds of noise",
                expected: ny,
                found: bounds.noise.len(),
            });
        }
        if let Some(&value) = bounds.noise.iter().find(|v| !(0.0 < **v && v.is_finite())) {
            return Err(ModelError::OutOfRange {
                role: "bound of noise",
                range: "(0, inf)",
                value,
            }
            .into());
        }
        if MOST_COLUMNS < columns {
            let value = columns as f64;
            return Err(ModelError::OutOfRange {
                role: "columns of a zonotope",
                range: "[states, 100000]",
                value,
            }
            .into());
        }
        let start = bounds.initial.clone().unwrap_or_else(|| vec![0.0; nx]);
        let mut design = Self { observer, bounds, columns, start, settled: Vec::new() };
        design.settle()?;
        Ok(design)
    }

    /// Lets the set grow at rest until it no longer does.
    fn settle(&mut self) -> Result<(), DesignError> {
        let io = GeneratorDesign::io(self);
        let (u, y) = (vec![0.0; io.nu], vec![0.0; io.ny]);
        let mut running = self.freeze::<f64>()?;
        let mut r = vec![0.0; io.ny];
        let (mut before, mut next) = (vec![0.0; io.ny], 20);
        for k in 0..LONGEST {
            let frame = Frame::new(io, k as u64, &u, &y)
                .map_err(|_| DesignError::Unbounded { samples: k })?;
            running.step(frame, &mut r);
            if k < next {
                continue;
            }
            let widths = running.half_widths();
            let grown = |(new, old): (&f64, &f64)| (new - old).abs() > SETTLED * new.abs();
            if widths.iter().any(|w| !w.is_finite()) {
                break;
            }
            if !widths.iter().zip(&before).any(grown) {
                self.settled = widths.to_vec();
                if self.bounds.initial.is_none() {
                    let states = running.states();
                    // What is left of the growth, and of the search for its end.
                    self.start =
                        (0..self.start.len()).map(|i| states.radius(i) * (1.0 + SETTLED)).collect();
                }
                return Ok(());
            }
            before.copy_from_slice(widths);
            next = k + k / 10 + 1;
        }
        Err(DesignError::Unbounded { samples: LONGEST })
    }

    /// Half widths of the predicted outputs at rest, after a long time, in the units of the outputs: a change of a
    /// sensor that is smaller can always be explained.
    #[must_use]
    pub fn settled(&self) -> &[f64] {
        &self.settled
    }

    /// Moves the observer to run time, starting at a box around zero.
    ///
    /// # Errors
    ///
    /// Returns an error when there are fewer columns than states, or the initial bounds do not fit.
    pub fn freeze<T: Scalar>(&self) -> Result<ZonotopeObserver<T>, DesignError> {
        let (m, gain) = (self.observer.model(), self.observer.gain());
        let (nx, ny, nw) = (m.nx(), m.ny(), self.bounds.disturbance.ncols());
        let columns_of = |m: MatRef<'_, f64>| -> Vec<Vec<T>> {
            let column = |j| (0..m.nrows()).map(|i| T::from_design(m[(i, j)])).collect();
            (0..m.ncols()).map(column).collect()
        };
        let [a, b, c, d] = self.bounds.model.each();
        let is_exact = [a, b, c, d].iter().all(|(_, bound)| bound.norm_max() <= 0.0);
        let of = |(role, bound): (&'static str, MatRef<'_, f64>)| freeze(role, bound);
        let parts = Parts {
            closed: freeze("observer transition A − L C", (m.a() - gain * m.c()).as_ref())?,
            b: freeze("input matrix B − L D", (m.b() - gain * m.d()).as_ref())?,
            gain: freeze("observer gain L", gain)?,
            c_rows: columns_of(m.c().transpose()),
            gain_columns: columns_of(gain),
            disturbance: columns_of(self.bounds.disturbance.as_ref()),
            d: freeze("feedthrough D", m.d())?,
            noise: self.bounds.noise.iter().map(|&v| T::from_design(v)).collect(),
            model: if is_exact { None } else { Some([of(a)?, of(b)?, of(c)?, of(d)?]) },
        };
        if self.columns < nx {
            return Err(DesignError::Count {
                what: "columns of a zonotope",
                expected: nx,
                found: self.columns,
            });
        }
        let room = self.columns + nw + ny + nx;
        let start = Zonotope::of_box(&vec![0.0; nx], &self.start, room)?;
        Ok(ZonotopeObserver::new(parts, start, self.columns))
    }
}

impl GeneratorDesign for ZonotopeDesign {
    fn io(&self) -> IoDims {
        GeneratorDesign::io(&self.observer)
    }

    fn residual_len(&self) -> usize {
        GeneratorDesign::residual_len(&self.observer)
    }

    /// The observer over the half widths at rest. What runs divides by those of the sample, which are other ones
    /// until the set has settled, and larger ones away from rest where the model is uncertain.
    fn form(&self) -> Result<ResidualForm, DesignError> {
        let ny = self.settled.len();
        let weights =
            Mat::from_fn(ny, ny, |i, j| if i == j { self.settled[i].recip() } else { 0.0 });
        WeightedDesign::new(self.observer.clone(), weights.as_ref())?.form()
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        Ok(Box::new(self.freeze::<f64>()?))
    }
}
