//! A model as the map from one sample to the next, with the state in the hands of the caller.

use std::sync::Arc;

use fd_core::IoDims;
use fd_model::{Channel, SampleTime};

use super::{
    equations::{Engine, System},
    error::SimulateError,
    simulator::Initial,
};
use crate::model::Model;

/// The state equations `x⁺ = f(x, u)`, `y = h(x, u)` of a [`Model`] with fixed parameters.
///
/// A [`Simulator`](super::Simulator) owns its state; an estimator asks for `f` at many states of the
/// same sample. The map integrates as a simulation does: chained, it gives the same bits.
///
/// ```
/// use fd_sim::{model::Model, simulate::StateMap};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = { u = { unit = "1" } }
/// outputs = { y = { unit = "1", value = "2*x" } }
/// states = { x = { unit = "1", initial = 0.0, derivative = "u - x" } }
/// "#.parse()?;
/// let mut map = StateMap::new(&model, &model.nominal(), model.sample_time()?)?;
/// let (mut y, mut next) = ([0.0], [0.0]);
/// map.output(0, &[3.0], &[0.0], &mut y);
/// map.advance(0, &[3.0], &[0.0], &[0.0], &mut next);
/// assert!(y == [6.0] && (next[0] - 3.0 * (-0.1_f64).exp()).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StateMap {
    engine: Engine<f64>,
    y: Vec<f64>,
}

impl StateMap {
    /// The map of a model with parameters `theta`, for samples `ts` apart.
    ///
    /// # Errors
    ///
    /// Returns an error when the number of parameters is wrong, no integration step can be found, or the
    /// model remembers more than its states: a delay, or what a sampled controller holds.
    pub fn new(model: &Model, theta: &[f64], ts: SampleTime) -> Result<Self, SimulateError> {
        let (expected, found) = (model.parameters.len(), theta.len());
        if expected != found {
            return Err(SimulateError::Length { what: "parameters", expected, found });
        }
        if let Some(delay) = model.delays.first() {
            return Err(SimulateError::Remembers { what: "a delay", name: delay.name.clone() });
        }
        if let Some(sign) = model.signs.first() {
            let what = "the sign of a velocity";
            return Err(SimulateError::Remembers { what, name: sign.name.clone() });
        }
        if model.controller.as_ref().is_some_and(|controller| controller.sample_time.is_some()) {
            let (what, name) = ("a sampled controller", "controller".to_owned());
            return Err(SimulateError::Remembers { what, name });
        }
        let mut engine = Engine::new(Arc::new(System::new(model, ts, &[])?));
        engine.restart(theta, &model.initial(), 0);
        Ok(Self { engine, y: vec![0.0; model.outputs.len()] })
    }

    /// Time between samples.
    #[must_use]
    pub fn ts(&self) -> SampleTime {
        self.engine.system.ts
    }

    /// Numbers of external inputs and outputs.
    #[must_use]
    pub fn io(&self) -> IoDims {
        IoDims { nu: self.inputs().len(), ny: self.outputs().len() }
    }

    /// External inputs.
    #[must_use]
    pub fn inputs(&self) -> &[Channel] {
        &self.engine.system.inputs
    }

    /// Outputs.
    #[must_use]
    pub fn outputs(&self) -> &[Channel] {
        &self.engine.system.channels
    }

    /// States, with what is known of their initial values.
    #[must_use]
    pub fn states(&self) -> &[Initial] {
        &self.engine.system.initial
    }

    /// Writes the outputs of sample number `sample` of a run. Does not allocate.
    ///
    /// # Panics
    ///
    /// Panics when the numbers of values are wrong.
    pub fn output(&mut self, sample: u64, x: &[f64], u: &[f64], y: &mut [f64]) {
        self.place(sample, x);
        self.engine.measure_now(u, y);
    }

    /// Writes the state at the sample after `sample`, of which the inputs are `u_next`; these matter
    /// only where inputs are interpolated. NaN when the integration diverges. Does not allocate.
    ///
    /// # Panics
    ///
    /// Panics when the numbers of values are wrong.
    pub fn advance(
        &mut self,
        sample: u64,
        x: &[f64],
        u: &[f64],
        u_next: &[f64],
        x_next: &mut [f64],
    ) {
        self.place(sample, x);
        self.engine.advance(u, u_next, &[], &mut self.y);
        x_next.copy_from_slice(&self.engine.x);
    }

    fn place(&mut self, sample: u64, x: &[f64]) {
        self.engine.x.copy_from_slice(x);
        self.engine.sample = sample;
        self.engine.is_first = sample == 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::{EquationSimulator, Simulator};

    const PENDULUM: &str = r#"
    version = 1
    kind = "equations"
    name = "pendulum"
    sample_time = 0.05
    hold = "linear"
    [parameters]
    d = { unit = "1/s", value = 0.3 }
    [inputs]
    u = { unit = "1/s^2" }
    [outputs]
    y = { unit = "rad", value = "q + 0.1*t" }
    [states]
    q = { unit = "rad", initial = 0.4, derivative = "w" }
    w = { unit = "rad/s", initial = 0.0, derivative = "u - 4*sin(q) - d*w" }
    n = { unit = "1", initial = 0.0, update = "n + dt" }
    "#;

    #[test]
    fn chained_it_is_the_simulation_to_the_bit() {
        let model: Model = PENDULUM.parse().unwrap();
        let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
        let mut map =
            StateMap::new(&model, &model.nominal(), model.sample_time().unwrap()).unwrap();
        let u: Vec<f64> = (0..60).map(|k| (0.3 * f64::from(k)).sin()).collect();
        simulator.start(&model.nominal(), &model.initial(), 0);
        let (mut x, mut next) = (model.initial(), vec![0.0; 3]);
        let (mut ours, mut theirs) = ([0.0], [0.0]);
        for k in 0..59 {
            let (now, then) = (&u[k..=k], &u[k + 1..k + 2]);
            // Questions in between leave no trace.
            map.advance(k as u64, &[9.0, 9.0, 9.0], now, then, &mut next);
            map.output(k as u64, &x, now, &mut ours);
            map.advance(k as u64, &x, now, then, &mut next);
            simulator.step(now, then, &[], &mut theirs);
            assert_eq!(ours.map(f64::to_bits), theirs.map(f64::to_bits), "output {k}");
            assert_eq!(next, simulator.state(), "state {k}");
            x.copy_from_slice(&next);
        }
    }

    #[test]
    fn what_remembers_more_than_states_is_refused() {
        let delays = "[delays]\nlate = { value = \"u\", time = \"0.1\" }\n[inputs]";
        let text = PENDULUM.replace("n + dt", "n + late").replace("[inputs]", delays);
        let model: Model = text.parse().unwrap();
        let error = StateMap::new(&model, &model.nominal(), model.sample_time().unwrap());
        assert!(matches!(error, Err(SimulateError::Remembers { what: "a delay", .. })));
        let error = StateMap::new(&model, &[], model.sample_time().unwrap());
        assert!(matches!(error, Err(SimulateError::Length { expected: 1, found: 0, .. })));
    }
}
