//! Continuous and discrete time as types, so that the two cannot be mixed up.

use std::f64::consts::PI;

use faer::{Mat, MatRef, c64};

use crate::{error::ModelError, linalg::Cayley, state_space::StateSpace};

/// A time axis on which a linear model lives.
///
/// Implemented for [`Continuous`] and [`Discrete`], so that an analysis is written once and a model of one
/// kind cannot be joined with one of the other. What differs between the two is in these methods and
/// nowhere else.
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, ModelError, SampleTime, StateSpace, TimeDomain};
///
/// /// How far the slowest mode is from not dying out.
/// fn slowest<D: TimeDomain>(model: &StateSpace<D>) -> Result<f64, ModelError> {
///     let poles = model.poles()?;
///     Ok(poles.iter().map(|&p| model.domain().margin(p)).fold(f64::INFINITY, f64::min))
/// }
///
/// let lag = StateSpace::new(mat![[-2.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
/// let sampled = lag.sample_zoh(SampleTime::new(0.1)?)?;
/// assert_eq!(slowest(&lag)?, 2.0);
/// assert!((slowest(&sampled)? - (1.0 - (-0.2_f64).exp())).abs() < 1e-15);
/// # Ok::<(), ModelError>(())
/// ```
pub trait TimeDomain: Copy + Sized {
    /// Distance of an eigenvalue from the edge of stability, positive when its mode dies out.
    fn margin(&self, eigenvalue: c64) -> f64;

    /// The point at which a transfer matrix is evaluated for a sinusoid of `omega` rad/s.
    fn point(&self, omega: f64) -> c64;

    /// The point at which a transfer matrix gives the steady-state gain: `s = 0` or `z = 1`.
    fn steady_point(&self) -> f64;

    /// Largest frequency that tells itself apart, in rad/s: infinite or `π/Ts`.
    fn highest_frequency(&self) -> f64;

    /// The square of the H2 norm of a constant gain, given the square of its Frobenius norm.
    ///
    /// White noise of finite intensity has infinite variance in continuous time, so that any
    /// feedthrough makes the norm infinite there.
    fn feedthrough_h2_squared(&self, frobenius_squared: f64) -> f64;

    /// The common time axis of two models that are to be connected.
    ///
    /// # Errors
    ///
    /// Returns an error when the sample times differ.
    fn join(self, other: Self) -> Result<Self, ModelError>;

    /// Discrete matrices `(A, B, C)` with the same gramians as a model on this axis, and stable
    /// if it is.
    ///
    /// # Errors
    ///
    /// Returns an error when `A` has an eigenvalue in the unstable region that the mapping sends
    /// to infinity.
    fn smith_system(
        &self,
        a: MatRef<'_, f64>,
        b: MatRef<'_, f64>,
        c: MatRef<'_, f64>,
    ) -> Result<[Mat<f64>; 3], ModelError>;

    /// A continuous model with the same gains in another order of frequencies, and the same
    /// H-infinity norm.
    ///
    /// # Errors
    ///
    /// Returns an error when a pole lies where the mapping sends it to infinity.
    fn half_plane(model: &StateSpace<Self>) -> Result<StateSpace<Continuous>, ModelError>;

    /// The model on this axis whose [`half_plane`](TimeDomain::half_plane) is the given one.
    ///
    /// # Errors
    ///
    /// Returns an error when a pole lies where the mapping sends it to infinity.
    fn of_half_plane(self, model: &StateSpace<Continuous>) -> Result<StateSpace<Self>, ModelError>;

    /// The frequency on this axis at which [`TimeDomain::half_plane`] has the gain of `omega`.
    fn frequency_of_half_plane(&self, omega: f64) -> f64;

    /// Whether a mode with this eigenvalue dies out.
    fn decays(&self, eigenvalue: c64) -> bool {
        0.0 < self.margin(eigenvalue)
    }
}

/// Time in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Continuous;

/// Time in samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrete {
    /// Time between samples.
    pub ts: SampleTime,
}

/// A positive, finite time between samples, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct SampleTime(f64);

impl TimeDomain for Continuous {
    fn margin(&self, eigenvalue: c64) -> f64 {
        -eigenvalue.re
    }

    fn point(&self, omega: f64) -> c64 {
        c64::new(0.0, omega)
    }

    fn steady_point(&self) -> f64 {
        0.0
    }

    fn highest_frequency(&self) -> f64 {
        f64::INFINITY
    }

    fn feedthrough_h2_squared(&self, frobenius_squared: f64) -> f64 {
        if 0.0 < frobenius_squared { f64::INFINITY } else { 0.0 }
    }

    fn join(self, _: Self) -> Result<Self, ModelError> {
        Ok(self)
    }

    fn smith_system(
        &self,
        a: MatRef<'_, f64>,
        b: MatRef<'_, f64>,
        c: MatRef<'_, f64>,
    ) -> Result<[Mat<f64>; 3], ModelError> {
        let transform = Cayley::new(a)?;
        Ok([transform.a(), transform.b(b), transform.c(c)])
    }

    fn half_plane(model: &StateSpace<Self>) -> Result<StateSpace<Continuous>, ModelError> {
        Ok(model.clone())
    }

    fn of_half_plane(self, model: &StateSpace<Continuous>) -> Result<StateSpace<Self>, ModelError> {
        Ok(model.clone())
    }

    fn frequency_of_half_plane(&self, omega: f64) -> f64 {
        omega
    }
}

impl TimeDomain for Discrete {
    fn margin(&self, eigenvalue: c64) -> f64 {
        unit_disk_margin(eigenvalue)
    }

    fn point(&self, omega: f64) -> c64 {
        c64::from_polar(1.0, omega * self.ts.seconds())
    }

    fn steady_point(&self) -> f64 {
        1.0
    }

    fn highest_frequency(&self) -> f64 {
        PI / self.ts.seconds()
    }

    fn feedthrough_h2_squared(&self, frobenius_squared: f64) -> f64 {
        frobenius_squared
    }

    fn join(self, other: Self) -> Result<Self, ModelError> {
        // Two ways to the same sample time may differ in rounding.
        let (expected, found) = (self.ts.seconds(), other.ts.seconds());
        if (expected - found).abs() <= 4.0 * f64::EPSILON * expected {
            Ok(self)
        } else {
            Err(ModelError::SampleTimeMismatch { expected, found })
        }
    }

    fn smith_system(
        &self,
        a: MatRef<'_, f64>,
        b: MatRef<'_, f64>,
        c: MatRef<'_, f64>,
    ) -> Result<[Mat<f64>; 3], ModelError> {
        Ok([a.to_owned(), b.to_owned(), c.to_owned()])
    }

    fn half_plane(model: &StateSpace<Self>) -> Result<StateSpace<Continuous>, ModelError> {
        model.undo_tustin()
    }

    fn of_half_plane(self, model: &StateSpace<Continuous>) -> Result<StateSpace<Self>, ModelError> {
        model.sample_tustin(self.ts)
    }

    fn frequency_of_half_plane(&self, omega: f64) -> f64 {
        2.0 * (omega * self.ts.seconds() / 2.0).atan() / self.ts.seconds()
    }
}

/// Distance from the unit circle, positive inside.
pub(crate) fn unit_disk_margin(eigenvalue: c64) -> f64 {
    1.0 - eigenvalue.norm()
}

impl SampleTime {
    /// Checks a sample time.
    ///
    /// # Errors
    ///
    /// Returns an error unless `0 < seconds < ∞`.
    pub fn new(seconds: f64) -> Result<Self, ModelError> {
        if 0.0 < seconds && seconds.is_finite() {
            Ok(Self(seconds))
        } else {
            Err(ModelError::SampleTime { seconds })
        }
    }

    /// Seconds between samples.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0
    }
}
