//! The nonlinear engine as a discrete-time plant: Runge-Kutta with the fuel held between samples.

use fd_core::{IoDims, Scalar, stage::Plant};
use fd_model::SampleTime;

use super::{
    dynamics::{Dynamics, check_state},
    state::NY,
};
use crate::{error::EngineError, runge_kutta};

/// Longest internal step, s.
///
/// The classical Runge-Kutta method is stable for real poles up to `2.78 / step`. The fastest
/// pole of the engine is -542 1/s at idle, which allows 5.1 ms; half of it leaves room for
/// deterioration and for leaner points.
pub const MAX_STEP: f64 = 2.5e-3;

/// An engine sampled with a zero-order hold, in physical units.
///
/// As a [`Plant`] it writes NaN once it has left its region of validity;
/// [`Sampled::try_advance`] says why.
///
/// ```
/// use fd_core::stage::Plant;
/// use fd_jetengine::engine17::{Engine17, Parameters, Sampled};
/// use fd_model::SampleTime;
///
/// let engine = Engine17::<f64>::new(&Parameters::default())?;
/// let trim = engine.trim(0.712)?;
/// let plant = Sampled::new(engine, SampleTime::new(0.02)?);
/// let mut next = [0.0; 17];
/// plant.advance(&trim.x, &[0.72], &mut next);
/// assert!(next[0] > trim.x[0]);
/// # Ok::<(), fd_jetengine::EngineError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sampled<E, const N: usize> {
    engine: E,
    substeps: u32,
    step: f64,
}

impl<E, const N: usize> Sampled<E, N> {
    /// Splits the sample time into the fewest equal steps of at most [`MAX_STEP`].
    #[must_use]
    pub fn new<T: Scalar>(engine: E, ts: SampleTime) -> Self
    where
        E: Dynamics<T, N>,
    {
        Self::with_longest_step(engine, ts, MAX_STEP)
    }

    /// The same with steps of at most `longest` s, for those who pay for each. The method is stable up to 8 ms at the
    /// reference point and up to 5 ms at idle.
    ///
    /// ```
    /// use fd_jetengine::engine17::{Engine17, Parameters, Sampled};
    /// use fd_model::SampleTime;
    ///
    /// let engine = Engine17::<f64>::new(&Parameters::default())?;
    /// let plant: Sampled<_, 17> = Sampled::with_longest_step::<f64>(engine, SampleTime::new(0.05)?, 5e-3);
    /// assert_eq!(plant.substeps(), 10);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_longest_step<T: Scalar>(engine: E, ts: SampleTime, longest: f64) -> Self
    where
        E: Dynamics<T, N>,
    {
        let (substeps, step) = runge_kutta::substeps(ts, longest);
        Self { engine, substeps, step }
    }

    /// The engine.
    #[must_use]
    pub fn engine(&self) -> &E {
        &self.engine
    }

    /// The engine, for instance to change its health between samples.
    pub fn engine_mut(&mut self) -> &mut E {
        &mut self.engine
    }

    /// Number of Runge-Kutta steps per sample.
    #[must_use]
    pub fn substeps(&self) -> u32 {
        self.substeps
    }

    /// The states one sample later, at a constant fuel flow in kg/s.
    ///
    /// # Errors
    ///
    /// Returns an error when a compressor surges or a state stops being a positive number; the
    /// time in it counts from the beginning of the sample.
    pub fn try_advance<T: Scalar>(&self, x: &[T; N], fuel: T) -> Result<[T; N], EngineError>
    where
        E: Dynamics<T, N>,
    {
        let mut x = *x;
        for n in 0..self.substeps {
            x = try_step(&self.engine, &x, fuel, self.step, f64::from(n) * self.step)?;
        }
        Ok(x)
    }
}

/// One step of the classical Runge-Kutta method, with the engine checked at its start.
pub(super) fn try_step<T: Scalar, const N: usize>(
    engine: &impl Dynamics<T, N>,
    x: &[T; N],
    fuel: T,
    step: f64,
    time: f64,
) -> Result<[T; N], EngineError> {
    check_state(x, time)?;
    let (k1, auxiliary) = engine.rates(x, fuel);
    engine.surge_limits().check(&auxiliary, time)?;
    let next = runge_kutta::step(x, &k1, step, |x| engine.rates(x, fuel).0);
    check_state(&next, time + step)?;
    Ok(next)
}

impl<T: Scalar, E: Dynamics<T, N>, const N: usize> Plant<T> for Sampled<E, N> {
    fn nx(&self) -> usize {
        N
    }

    fn io(&self) -> IoDims {
        IoDims { nu: 1, ny: NY }
    }

    fn advance(&self, x: &[T], u: &[T], x_next: &mut [T]) {
        let nan = [T::from_design(f64::NAN); N];
        let next = match (x.try_into(), u) {
            (Ok(x), &[fuel]) => self.try_advance(x, fuel).unwrap_or(nan),
            _ => nan,
        };
        x_next.copy_from_slice(&next);
    }

    fn output(&self, x: &[T], _u: &[T], y: &mut [T]) {
        for (y, i) in y.iter_mut().zip(self.engine.measured()) {
            *y = x[i];
        }
    }
}

/// A sampled engine in relative deviations from an equilibrium, so that it has the signals of
/// the per-unit linear model and starts from zero like it.
#[derive(Clone, Debug)]
pub struct PerUnit<E, const N: usize> {
    plant: Sampled<E, N>,
    x_0: [f64; N],
    fuel_0: f64,
}

impl<E: Dynamics<f64, N>, const N: usize> PerUnit<E, N> {
    /// Deviations from the equilibrium `x_0` at `fuel_0` (kg/s).
    ///
    /// # Errors
    ///
    /// Returns an error when a state of the equilibrium is not a positive number.
    pub fn new(plant: Sampled<E, N>, x_0: [f64; N], fuel_0: f64) -> Result<Self, EngineError> {
        check_state(&x_0, 0.0)?;
        Ok(Self { plant, x_0, fuel_0 })
    }

    /// The deviations one sample later.
    ///
    /// # Errors
    ///
    /// As [`Sampled::try_advance`].
    pub fn try_advance(&self, x: &[f64; N], u: f64) -> Result<[f64; N], EngineError> {
        let absolute = std::array::from_fn(|i| self.x_0[i] * (1.0 + x[i]));
        let next = self.plant.try_advance(&absolute, self.fuel_0 * (1.0 + u))?;
        Ok(std::array::from_fn(|i| next[i] / self.x_0[i] - 1.0))
    }
}

impl<E, const N: usize> PerUnit<E, N> {
    /// The engine in physical units.
    #[must_use]
    pub fn plant(&self) -> &Sampled<E, N> {
        &self.plant
    }

    /// The engine in physical units, for instance to change its health between samples.
    pub fn plant_mut(&mut self) -> &mut Sampled<E, N> {
        &mut self.plant
    }
}

impl<E: Dynamics<f64, N>, const N: usize> Plant<f64> for PerUnit<E, N> {
    fn nx(&self) -> usize {
        N
    }

    fn io(&self) -> IoDims {
        IoDims { nu: 1, ny: NY }
    }

    fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
        let nan = [f64::NAN; N];
        let next = match (x.try_into(), u) {
            (Ok(x), &[u]) => self.try_advance(x, u).unwrap_or(nan),
            _ => nan,
        };
        x_next.copy_from_slice(&next);
    }

    fn output(&self, x: &[f64], _u: &[f64], y: &mut [f64]) {
        for (y, i) in y.iter_mut().zip(self.plant.engine.measured()) {
            *y = x[i];
        }
    }
}
