//! Equilibria: damped Newton in relative deviations.

use faer::{Mat, prelude::Solve};
use fd_numeric::dense::Dense;

use super::{
    auxiliary::Auxiliary,
    dynamics::{Dynamics, check_state},
    jacobian::relative_jacobian,
    rhs::Engine17,
    state::{MEASURED, NX, NY, State},
};
use crate::error::EngineError;

/// An equilibrium of the engine.
#[derive(Clone, Debug, PartialEq)]
pub struct Trim {
    /// States.
    pub x: [f64; NX],
    /// Fuel flow, kg/s.
    pub fuel: f64,
    /// The gas path.
    pub auxiliary: Auxiliary,
    /// Newton iterations spent.
    pub iterations: usize,
    /// Largest `|ẋ_i / x_i|`, 1/s.
    pub residual: f64,
}

impl Trim {
    /// Outputs `N_L, N_H, T_7, P_6, T_29`.
    #[must_use]
    pub fn outputs(&self) -> [f64; NY] {
        MEASURED.map(|i| self.x[i])
    }
}

/// Largest relative change of a state in one iteration.
const STEP_CAP: f64 = 0.2;

/// A relative step below this ends the iteration. The next step would be its square, far below
/// rounding; rounding of the fluxes leaves about 1e-13.
const CONVERGED: f64 = 1e-11;

/// Iterations before giving up; a slam from one end of the range to the other takes about 15.
const MAX_ITERATIONS: usize = 60;

/// Largest relative rate of an equilibrium, 1/s: a change of 1e-9 in a second.
const LARGEST_RESIDUAL: f64 = 1e-9;

impl Engine17<f64> {
    /// The equilibrium at a fuel flow in kg/s, starting from the reference point
    /// corrected to the flight condition.
    ///
    /// Each step of Newton's method is shortened so that no state changes by more than 20 %.
    ///
    /// # Errors
    ///
    /// [`EngineError::NoTrim`] when the iteration does not settle, [`EngineError::Surge`] when
    /// it settles on a point beyond the surge line.
    ///
    /// ```
    /// use fd_jetengine::engine17::{Engine17, Parameters};
    ///
    /// let idle = Engine17::new(&Parameters::default())?.trim(0.12)?;
    /// assert!(idle.residual < 1e-10);
    /// assert!((idle.auxiliary.bypass_ratio - 0.976).abs() < 1e-3);
    /// # Ok::<(), fd_jetengine::EngineError>(())
    /// ```
    pub fn trim(&self, fuel: f64) -> Result<Trim, EngineError> {
        self.trim_from(fuel, &self.reference_state().to_array())
    }

    /// The reference point in corrected terms at this flight condition: a first guess.
    fn reference_state(&self) -> State {
        let s = self.design().reference;
        let ambient = self.environment().ambient();
        let theta = ambient.total_temperature / self.design().t_1;
        let delta = ambient.total_pressure * self.parameters().ram_recovery / self.design().p_1;
        let (root, flow) = (theta.sqrt(), delta / theta.sqrt());
        State {
            n_l: s.n_l * root,
            n_h: s.n_h * root,
            w_2: s.w_2 * flow,
            p_2: s.p_2 * delta,
            p_3: s.p_3 * delta,
            t_4: s.t_4 * theta,
            p_5: s.p_5 * delta,
            t_5: s.t_5 * theta,
            p_6: s.p_6 * delta,
            t_6: s.t_6 * theta,
            w_6: s.w_6 * flow,
            w_b: s.w_b * flow,
            p_29: s.p_29 * delta,
            t_29: s.t_29 * theta,
            w_29: s.w_29 * flow,
            ps_7: s.ps_7 * delta,
            t_7: s.t_7 * theta,
        }
    }

    /// The equilibrium at a fuel flow in kg/s, starting from `guess`.
    ///
    /// # Errors
    ///
    /// As [`Engine17::trim`].
    pub fn trim_from(&self, fuel: f64, guess: &[f64; NX]) -> Result<Trim, EngineError> {
        let mut x = *guess;
        let mut residual = f64::INFINITY;
        for iterations in 1..=MAX_ITERATIONS {
            let rates = self.rhs(&x, fuel);
            let negative = Mat::from_fn(NX, 1, |i, _| -rates[i] / x[i]);
            residual = largest(negative.col(0).iter());
            let jacobian = relative_jacobian(self, &x, fuel);
            let step = jacobian.lu().solve(&negative);
            let length = largest(step.col(0).iter());
            if !length.is_finite() {
                return Err(EngineError::NoTrim { fuel, iterations, residual });
            }
            let damping = (STEP_CAP / length).min(1.0);
            for (i, x) in x.iter_mut().enumerate() {
                *x *= 1.0 + damping * step[(i, 0)];
            }
            if length < CONVERGED {
                return self.accept(x, fuel, iterations);
            }
        }
        Err(EngineError::NoTrim { fuel, iterations: MAX_ITERATIONS, residual })
    }

    fn accept(&self, x: [f64; NX], fuel: f64, iterations: usize) -> Result<Trim, EngineError> {
        check_state(&x, 0.0)?;
        let (rates, auxiliary) = self.rates(&x, fuel);
        let ratios: [f64; NX] = std::array::from_fn(|i| rates[i] / x[i]);
        let residual = largest(ratios.iter());
        if residual > LARGEST_RESIDUAL {
            return Err(EngineError::NoTrim { fuel, iterations, residual });
        }
        self.surge_limits().check(&auxiliary, 0.0)?;
        Ok(Trim { x, fuel, auxiliary, iterations, residual })
    }
}

/// Largest magnitude; NaN when there is one.
fn largest<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    values.fold(0.0, |m, v| if v.is_nan() || v.abs() > m { v.abs() } else { m })
}
