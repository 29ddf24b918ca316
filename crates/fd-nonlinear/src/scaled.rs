//! State equations whose inputs and outputs are deviations from an operating point, in units of a scale.

use fd_core::IoDims;
use fd_model::{ChannelScale, Scaling};

use crate::{error::NonlinearError, model::StateEquations};

/// State equations in the signals of a scaled pipeline; the states stay in their units.
#[derive(Clone, Debug)]
pub struct ScaledEquations {
    inside: Box<dyn StateEquations>,
    scaling: Scaling,
    u: Vec<f64>,
    u_next: Vec<f64>,
}

impl ScaledEquations {
    /// Equations that take `(u − offset) / scale` and give `(y − offset) / scale`.
    ///
    /// # Errors
    ///
    /// Returns an error when there is not one scale per channel, or a scale is zero or not finite.
    ///
    /// ```
    /// use fd_model::{ChannelScale, Scaling};
    /// use fd_nonlinear::{ScaledEquations, StateEquations};
    /// use fd_sim::{model::Model, simulate::StateMap};
    ///
    /// let model: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "heater"
    /// sample_time = 1.0
    /// inputs = { p = { unit = "W" } }
    /// states = { T = { unit = "K", initial = 300.0, update = "T + 0.01*p" } }
    /// outputs = { T_m = { unit = "K", value = "T" } }
    /// "#.parse()?;
    /// let map = StateMap::new(&model, &[], model.sample_time()?)?;
    /// let scaling = Scaling {
    ///     inputs: vec![ChannelScale::per_unit(0.0, 1000.0)],
    ///     outputs: vec![ChannelScale::per_unit(300.0, 10.0)],
    /// };
    /// let mut scaled = ScaledEquations::new(map, scaling)?;
    /// let (mut next, mut y) = ([0.0], [0.0]);
    /// scaled.advance(0, &[300.0], &[2.0], &[2.0], &mut next);
    /// scaled.output(1, &next, &[0.0], &mut y);
    /// assert_eq!((next, y), ([320.0], [2.0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        inside: impl StateEquations + 'static,
        scaling: Scaling,
    ) -> Result<Self, NonlinearError> {
        check_scaling(inside.io(), &scaling)?;
        let nu = inside.io().nu;
        Ok(Self { inside: Box::new(inside), scaling, u: vec![0.0; nu], u_next: vec![0.0; nu] })
    }
}

/// Whether there is one usable scale per channel.
pub(crate) fn check_scaling(io: IoDims, scaling: &Scaling) -> Result<(), NonlinearError> {
    for (what, expected, scales) in [
        ("scales of inputs", io.nu, &scaling.inputs),
        ("scales of outputs", io.ny, &scaling.outputs),
    ] {
        let found = scales.len();
        if expected != found {
            return Err(NonlinearError::Length { what, expected, found });
        }
        for (i, scale) in scales.iter().enumerate() {
            let found = scale.scale.unwrap_or(1.0);
            if !(found.is_normal() && scale.offset.is_finite()) {
                let expected = "finite and not 0, about a finite operating point";
                return Err(NonlinearError::Number { what, index: i + 1, expected, found });
            }
        }
    }
    Ok(())
}

/// Signals of a pipeline in their units.
pub(crate) fn to_units(scales: &[ChannelScale], values: &[f64], to: &mut [f64]) {
    for ((to, value), scale) in to.iter_mut().zip(values).zip(scales) {
        *to = scale.physical(*value);
    }
}

impl StateEquations for ScaledEquations {
    fn nx(&self) -> usize {
        self.inside.nx()
    }

    fn io(&self) -> IoDims {
        self.inside.io()
    }

    fn output(&mut self, sample: u64, x: &[f64], u: &[f64], y: &mut [f64]) {
        to_units(&self.scaling.inputs, u, &mut self.u);
        self.inside.output(sample, x, &self.u, y);
        y.iter_mut().zip(&self.scaling.outputs).for_each(|(y, scale)| *y = scale.scaled(*y));
    }

    fn advance(&mut self, sample: u64, x: &[f64], u: &[f64], u_next: &[f64], x_next: &mut [f64]) {
        to_units(&self.scaling.inputs, u, &mut self.u);
        to_units(&self.scaling.inputs, u_next, &mut self.u_next);
        self.inside.advance(sample, x, &self.u, &self.u_next, x_next);
    }

    fn boxed(&self) -> Box<dyn StateEquations> {
        Box::new(self.clone())
    }
}
