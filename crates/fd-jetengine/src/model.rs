//! A linear engine with names, units and the point it belongs to: the common form of every plant.

use faer::{Mat, prelude::Solve};
use fd_model::{Channel, Continuous, ModelError, StateSpace};
use fd_numeric::dense::Dense;

use crate::error::EngineError;

/// Values about which a linear model holds.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatingPoint {
    /// States, in their units.
    pub x: Vec<f64>,
    /// Inputs, in their units.
    pub u: Vec<f64>,
    /// Outputs, in their units.
    pub y: Vec<f64>,
}

/// What one unit of each signal of a scaled model is worth in the unit of the unscaled one.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    /// Of the states.
    pub x: Vec<f64>,
    /// Of the inputs.
    pub u: Vec<f64>,
    /// Of the outputs.
    pub y: Vec<f64>,
}

/// A linear engine: deviations of outputs from deviations of inputs.
#[derive(Clone, Debug)]
pub struct EngineModel {
    /// Short name, such as `engine17 ref`.
    pub name: String,
    /// The model, in the units of the channels.
    pub model: StateSpace<Continuous>,
    /// Input channels.
    pub inputs: Vec<Channel>,
    /// Output channels.
    pub outputs: Vec<Channel>,
    /// State channels.
    pub states: Vec<Channel>,
    /// Point of linearisation, when it is known.
    pub operating_point: Option<OperatingPoint>,
    /// Source and caveats.
    pub note: String,
}

impl EngineModel {
    /// The model for relative deviations: every signal divided by its value at the operating
    /// point. All channels become pure numbers.
    ///
    /// # Errors
    ///
    /// Returns an error when the operating point is not known or one of its values is zero;
    /// use [`EngineModel::equilibrated`] then.
    pub fn per_unit(&self) -> Result<Self, EngineError> {
        let point = self.operating_point.clone().ok_or(EngineError::NoOperatingPoint)?;
        self.scaled(&Scaling { x: point.x, u: point.u, y: point.y })
    }

    /// Scales by steady responses, for models whose operating point is not published.
    ///
    /// Rows and columns of the DC gain are divided by the square roots of their largest entries
    /// until all largest entries are 1 (Ruiz 2001); each state is then divided by its largest
    /// steady response to a unit of any input. The choice makes inputs equally strong and
    /// outputs equally large; it says nothing about the accuracy of the sensors.
    ///
    /// # Errors
    ///
    /// Returns an error when `A` is singular, or an output or state does not answer any input.
    pub fn equilibrated(&self) -> Result<(Self, Scaling), EngineError> {
        let m = &self.model;
        let steady: Mat<f64> = m.a().lu().solve(&(-m.b()));
        let gain = m.c() * &steady + m.d();
        let mut u = vec![1.0; m.nu()];
        let mut y = vec![1.0; m.ny()];
        let entry = |u: &[f64], y: &[f64], i: usize, j: usize| (gain[(i, j)] * u[j] / y[i]).abs();
        for _ in 0..EQUILIBRATION_PASSES {
            let rows: Vec<f64> =
                (0..y.len()).map(|i| largest((0..u.len()).map(|j| entry(&u, &y, i, j)))).collect();
            let columns: Vec<f64> =
                (0..u.len()).map(|j| largest((0..y.len()).map(|i| entry(&u, &y, i, j)))).collect();
            y.iter_mut().zip(rows).for_each(|(s, row)| *s *= row.sqrt());
            u.iter_mut().zip(columns).for_each(|(s, column)| *s /= column.sqrt());
        }
        let x = (0..m.nx())
            .map(|i| largest((0..u.len()).map(|j| (steady[(i, j)] * u[j]).abs())))
            .collect();
        let scaling = Scaling { x, u, y };
        Ok((self.scaled(&scaling)?, scaling))
    }

    /// The model in units of the given sizes; channels become pure numbers.
    ///
    /// # Errors
    ///
    /// Returns an error when a size is zero or not finite, or there are too few.
    pub fn scaled(&self, scaling: &Scaling) -> Result<Self, EngineError> {
        let m = &self.model;
        let Scaling { x, u, y } = scaling;
        for (role, sizes, count) in [
            ("state scaling", x, m.nx()),
            ("input scaling", u, m.nu()),
            ("output scaling", y, m.ny()),
        ] {
            if sizes.len() != count || !sizes.iter().all(|s| s.is_normal()) {
                return Err(ModelError::Singular { role }.into());
            }
        }
        let model = StateSpace::new(
            Mat::from_fn(m.nx(), m.nx(), |i, j| m.a()[(i, j)] * x[j] / x[i]),
            Mat::from_fn(m.nx(), m.nu(), |i, j| m.b()[(i, j)] * u[j] / x[i]),
            Mat::from_fn(m.ny(), m.nx(), |i, j| m.c()[(i, j)] * x[j] / y[i]),
            Mat::from_fn(m.ny(), m.nu(), |i, j| m.d()[(i, j)] * u[j] / y[i]),
            Continuous,
        )?;
        let pure = |channels: &[Channel]| -> Vec<Channel> {
            channels.iter().map(|c| Channel::new(c.name.clone(), "1")).collect()
        };
        let divide = |v: &[f64], s: &[f64]| v.iter().zip(s).map(|(v, s)| v / s).collect();
        Ok(Self {
            name: self.name.clone(),
            model,
            inputs: pure(&self.inputs),
            outputs: pure(&self.outputs),
            states: pure(&self.states),
            operating_point: self.operating_point.as_ref().map(|p| OperatingPoint {
                x: divide(&p.x, x),
                u: divide(&p.u, u),
                y: divide(&p.y, y),
            }),
            note: self.note.clone(),
        })
    }
}

/// Ruiz's iteration converges by half of the logarithm per pass: 60 passes reach rounding from
/// any spread of an `f64`.
const EQUILIBRATION_PASSES: usize = 60;

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}
