//! The grid of models, and the gain at each point.

use faer::{Mat, MatRef};
use fd_core::{IoDims, Shape, ShapeError, stage::ResidualGenerator};
use fd_model::{Discrete, ModelError, StateSpace, TimeDomain};
use fd_numeric::dense::DenseReal;

use super::{
    grid::{ScheduledPoint, SchedulingVariable, position},
    run::{Local, ScheduledObserver},
    stability::common_lyapunov,
};
use crate::{
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    observer::ObserverDesign,
};

/// Points between two of the grid at which stability is looked at.
const BETWEEN: usize = 8;

/// A gain-scheduled observer; runs as [`ScheduledObserver`].
#[derive(Clone, Debug)]
pub struct ScheduledDesign {
    points: Vec<ScheduledPoint>,
    gains: Vec<Mat<f64>>,
    variable: SchedulingVariable,
    any_speed: bool,
}

impl ScheduledDesign {
    /// Stationary Kalman gains at all points, for noises `q` on each state and `r` on each output (variances).
    ///
    /// # Errors
    ///
    /// As [`ObserverDesign::kalman`] at each point, and as [`with_gains`](Self::with_gains).
    ///
    /// # Examples
    ///
    /// A tank that drains faster the fuller it is, linearised at two levels, and filled in between:
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::{Frame, stage::ResidualGenerator};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{
    ///     GeneratorDesign,
    ///     scheduled::{ScheduledDesign, ScheduledPoint, SchedulingVariable},
    /// };
    ///
    /// // h⁺ = h + 0.1 (u − h²) is h⁺ − h₀ = (1 − 0.2 h₀) (h − h₀) + 0.1 (u − h₀²)
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let mut points = Vec::new();
    /// for h in [0.5, 0.75, 1.0, 1.25, 1.5] {
    ///     let a = mat![[1.0 - 0.2 * h]];
    ///     let model = StateSpace::new(a, mat![[0.1]], mat![[1.0]], mat![[0.0]], domain)?;
    ///     points.push(ScheduledPoint { at: h, model, x0: vec![h], u0: vec![h * h], y0: vec![h] });
    /// }
    /// let variable = SchedulingVariable::Output { index: 0, smoothing: 0.0 };
    /// let design = ScheduledDesign::kalman(points, variable, 1.0, 1.0)?;
    /// assert!(design.any_speed());
    /// let mut observer = design.build()?;
    /// let (mut h, mut r) = (0.5, [0.0]);
    /// for k in 0..200 {
    ///     observer.step(Frame::new(observer.io(), k, &[2.0], &[h])?, &mut r);
    ///     h += 0.1 * (2.0 - h * h);
    ///     // A single model about 0.5 would be off by more than 0.1 at the end.
    ///     assert!(k < 5 || r[0].abs() < 3e-3, "{k}: {}", r[0]);
    /// }
    /// assert!(1.4 < h);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn kalman(
        points: Vec<ScheduledPoint>,
        variable: SchedulingVariable,
        q: f64,
        r: f64,
    ) -> Result<Self, DesignError> {
        let gain = |point: &ScheduledPoint| {
            Ok::<_, DesignError>(ObserverDesign::kalman(&point.model, q, r)?.gain().to_owned())
        };
        let gains: Result<Vec<_>, _> = points.iter().map(gain).collect();
        Self::with_gains(points, gains?, variable)
    }

    /// Given gains, one per point.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no point, their values do not increase, models or steady states have other sizes
    /// than the first, the variable does not exist, or the error grows at a point or between two.
    pub fn with_gains(
        points: Vec<ScheduledPoint>,
        gains: Vec<Mat<f64>>,
        variable: SchedulingVariable,
    ) -> Result<Self, DesignError> {
        let Some(first) = points.first() else {
            return Err(DesignError::Empty { what: "operating point" });
        };
        if gains.len() != points.len() {
            let what = "observer gains, one per operating point";
            return Err(DesignError::Count { what, expected: points.len(), found: gains.len() });
        }
        let m = &first.model;
        let expected = Shape::new(m.ny(), m.nu());
        for (point, gain) in points.iter().zip(&gains) {
            m.domain().join(point.model.domain())?;
            let p = &point.model;
            let same = |role, expected: Shape, found: Shape| {
                if expected == found { Ok(()) } else { Err(ShapeError { role, expected, found }) }
            };
            same("model of an operating point", expected, Shape::new(p.ny(), p.nu()))?;
            same("states of an operating point", Shape::new(m.nx(), 1), Shape::new(p.nx(), 1))?;
            same("steady states", Shape::new(m.nx(), 1), Shape::new(point.x0.len(), 1))?;
            same("steady inputs", Shape::new(m.nu(), 1), Shape::new(point.u0.len(), 1))?;
            same("steady outputs", Shape::new(m.ny(), 1), Shape::new(point.y0.len(), 1))?;
            let gain = Shape::new(gain.nrows(), gain.ncols());
            same("observer gain L", Shape::new(m.nx(), m.ny()), gain)?;
        }
        let ordered = points.windows(2).all(|pair| pair[0].at < pair[1].at);
        let is_finite = |p: &ScheduledPoint| {
            let steady = [&p.x0, &p.u0, &p.y0].into_iter().flatten();
            p.at.is_finite() && steady.copied().all(f64::is_finite)
        };
        let finite = points.iter().all(is_finite);
        if !ordered || !finite {
            let value = points.iter().map(|p| p.at).find(|at| !at.is_finite()).unwrap_or(first.at);
            let role = "the scheduling variable at the operating points, in ascending order,";
            return Err(ModelError::OutOfRange { role, range: "(-inf, inf)", value }.into());
        }
        let (what, index, count, smoothing) = match variable {
            SchedulingVariable::Input { index, smoothing } => ("input", index, m.nu(), smoothing),
            SchedulingVariable::Output { index, smoothing } => ("output", index, m.ny(), smoothing),
        };
        if count <= index {
            return Err(DesignError::Index { what, index, count });
        }
        if !(0.0 <= smoothing && smoothing.is_finite()) {
            let role = "the smoothing of the scheduling variable, in samples,";
            return Err(ModelError::OutOfRange { role, range: "[0, inf)", value: smoothing }.into());
        }
        let mut design = Self { points, gains, variable, any_speed: false };
        let closed = design.closed_loops()?;
        design.any_speed = common_lyapunov(&closed);
        Ok(design)
    }

    /// `A − L C` at all points and between them, all of which have to decay.
    fn closed_loops(&self) -> Result<Vec<Mat<f64>>, DesignError> {
        let mut all = Vec::new();
        for at in self.looked_at() {
            let (model, gain) = self.at(at)?;
            let f = model.a() - &gain * model.c();
            let modes = f.modes().map_err(|_| ModelError::NoConvergence {
                what: "a scheduled observer",
                order: f.nrows(),
            })?;
            if let Some(mode) = modes.iter().find(|&&mode| !model.domain().decays(mode)) {
                let what = "a scheduled observer";
                return Err(ModelError::Unstable { what, re: mode.re, im: mode.im }.into());
            }
            all.push(f);
        }
        Ok(all)
    }

    fn looked_at(&self) -> Vec<f64> {
        let between = self.points.windows(2).flat_map(|pair| {
            let [low, high] = [pair[0].at, pair[1].at];
            (1..=BETWEEN).map(move |k| low + (high - low) * k as f64 / (BETWEEN + 1) as f64)
        });
        self.points.iter().map(|point| point.at).chain(between).collect()
    }

    /// The model and the gain at a value of the variable.
    ///
    /// # Errors
    ///
    /// Never fails for a checked design.
    pub fn at(&self, value: f64) -> Result<(StateSpace<Discrete>, Mat<f64>), DesignError> {
        let (low, share) = position(self.points.iter().map(|point| point.at), value);
        let high = (low + 1).min(self.points.len() - 1);
        let mix = |a: MatRef<'_, f64>, b: MatRef<'_, f64>| {
            Mat::from_fn(a.nrows(), a.ncols(), |i, j| (1.0 - share) * a[(i, j)] + share * b[(i, j)])
        };
        let (a, b) = (&self.points[low].model, &self.points[high].model);
        let model = StateSpace::new(
            mix(a.a(), b.a()),
            mix(a.b(), b.b()),
            mix(a.c(), b.c()),
            mix(a.d(), b.d()),
            a.domain(),
        )?;
        Ok((model, mix(self.gains[low].as_ref(), self.gains[high].as_ref())))
    }

    /// Whether the estimation error is proved to die out however fast the variable changes.
    #[must_use]
    pub fn any_speed(&self) -> bool {
        self.any_speed
    }

    /// The form at a value of the variable, while it stays there.
    ///
    /// # Errors
    ///
    /// Never fails for a checked design.
    pub fn form_at(&self, value: f64) -> Result<ResidualForm, DesignError> {
        let (model, gain) = self.at(value)?;
        ObserverDesign::with_gain(&model, gain.as_ref())?.form()
    }

    /// Moves the observer to run time, starting at the steady state of the first point.
    #[must_use]
    pub fn freeze(&self) -> ScheduledObserver {
        let local = |(point, gain): (&ScheduledPoint, &Mat<f64>)| Local::of(point, gain);
        let locals = self.points.iter().zip(&self.gains).map(local).collect();
        ScheduledObserver::new(locals, self.variable)
    }
}

/// The form is that at the first operating point.
impl GeneratorDesign for ScheduledDesign {
    fn io(&self) -> IoDims {
        let model = &self.points[0].model;
        IoDims { nu: model.nu(), ny: model.ny() }
    }

    fn residual_len(&self) -> usize {
        self.points[0].model.ny()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        self.form_at(self.points[0].at)
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        Ok(Box::new(self.freeze()))
    }
}
