//! A model with what is not known of it: noise, and where it starts.

use fd_core::IoDims;

use crate::{error::NonlinearError, model::StateEquations};

/// Standard deviations of independent, normal, white noises.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Added to each state per sample, in the unit of the state.
    pub process: Vec<f64>,
    /// Added to each output at each sample, in the unit of the output; above zero.
    pub output: Vec<f64>,
    /// Of each state at the first sample, in the unit of the state.
    pub initial: Vec<f64>,
}

/// `x(k+1) = f(x(k), u(k)) + w(k)`, `y(k) = h(x(k), u(k)) + v(k)`: what a filter is designed for.
#[derive(Clone, Debug)]
pub struct NoisyModel {
    equations: Box<dyn StateEquations>,
    start: Vec<f64>,
    noise: Noise,
}

impl NoisyModel {
    /// A model that starts at the state `start`, with these noises.
    ///
    /// # Errors
    ///
    /// Returns an error when there is not one number per channel, a standard deviation is negative or not
    /// finite, or one of an output is zero: a sensor without noise leaves nothing to weigh.
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::Heap;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_nonlinear::{Noise, NoisyModel, PlantEquations};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let equations = PlantEquations::new(lag.freeze::<f64, Heap>()?);
    /// let noise = |output| Noise { process: vec![0.1], output: vec![output], initial: vec![1.0] };
    /// assert!(NoisyModel::new(equations.clone(), vec![0.0], noise(0.2)).is_ok());
    /// assert!(NoisyModel::new(equations, vec![0.0], noise(0.0)).is_err());
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn new(
        equations: impl StateEquations + 'static,
        start: Vec<f64>,
        noise: Noise,
    ) -> Result<Self, NonlinearError> {
        let (nx, ny) = (equations.nx(), equations.io().ny);
        let lengths = [
            ("initial state", nx, start.len()),
            ("process noise", nx, noise.process.len()),
            ("initial deviation", nx, noise.initial.len()),
            ("output noise", ny, noise.output.len()),
        ];
        for (what, expected, found) in lengths {
            if expected != found {
                return Err(NonlinearError::Length { what, expected, found });
            }
        }
        let checks: [Check<'_>; 4] = [
            ("initial state", &start, "a finite number", f64::is_finite),
            ("process noise", &noise.process, "finite and not negative", is_deviation),
            ("initial deviation", &noise.initial, "finite and not negative", is_deviation),
            ("output noise", &noise.output, "finite and above 0", |v| is_deviation(v) && 0.0 < v),
        ];
        for (what, values, expected, is_right) in checks {
            if let Some(i) = values.iter().position(|&value| !is_right(value)) {
                return Err(NonlinearError::Number {
                    what,
                    index: i + 1,
                    expected,
                    found: values[i],
                });
            }
        }
        Ok(Self { equations: Box::new(equations), start, noise })
    }

    /// Number of states.
    #[must_use]
    pub fn nx(&self) -> usize {
        self.start.len()
    }

    /// Numbers of inputs and outputs.
    #[must_use]
    pub fn io(&self) -> IoDims {
        self.equations.io()
    }

    /// A copy of the equations.
    #[must_use]
    pub fn equations(&self) -> Box<dyn StateEquations> {
        self.equations.clone()
    }

    /// The state at the first sample.
    #[must_use]
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// The noises.
    #[must_use]
    pub fn noise(&self) -> &Noise {
        &self.noise
    }
}

/// What some numbers are, the numbers, what they have to be, and whether one is.
type Check<'a> = (&'static str, &'a [f64], &'static str, fn(f64) -> bool);

fn is_deviation(value: f64) -> bool {
    value.is_finite() && 0.0 <= value
}
