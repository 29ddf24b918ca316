//! Simulation: from inputs to a record, with noise and faults on the way.

use std::collections::BTreeMap;

use fd_core::stage::Plant;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    channel::Channel,
    error::ModelError,
    fault::{FaultError, FaultSpec, Parameters, RunningFault, Site},
    inputs::Inputs,
    record::Record,
    signal::{SignalError, SignalSpec},
};

/// What is added to a plain run of a plant: an initial state, noise, faults, and the size at
/// which a state counts as diverged.
///
/// The default is a run from the zero state without noise or faults.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_core::Heap;
/// use fd_model::{Channel, Discrete, Inputs, SampleTime, Simulation, StateSpace};
/// use fd_model::fault::{FaultProfile, FaultSpec, Site};
/// use fd_model::signal::Step;
///
/// let ts = SampleTime::new(0.1)?;
/// let (a, b, c, d) = (mat![[0.5]], mat![[0.5]], mat![[1.0]], mat![[0.0]]);
/// let plant = StateSpace::new(a, b, c, d, Discrete { ts })?.freeze::<f64, Heap>()?;
///
/// let inputs = Inputs::from_signals([(Channel::new("u", "1"), Step::new(1.0, 0.0))], 3, ts)?;
/// let mut simulation = Simulation::default();
/// simulation.faults = vec![FaultSpec::add(Site::sensor("y"), 0.2, FaultProfile::abrupt(4.0))];
/// let record = simulation.run(&plant, &inputs, vec![Channel::new("y", "1")])?;
/// assert_eq!(record.output(0).collect::<Vec<_>>(), [0.0, 0.5, 4.75]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Simulation {
    /// State at the first sample; empty for the zero state.
    pub x0: Vec<f64>,
    /// Noise added to each state at each step, in the order of the states; empty for none.
    pub state_noise: Vec<SignalSpec>,
    /// Noise of each sensor, in the order of the outputs; empty for none.
    pub output_noise: Vec<SignalSpec>,
    /// Faults; several on one signal act one after the other, in this order.
    pub faults: Vec<FaultSpec>,
    /// Size beyond which a state counts as diverged; without it only NaN and infinity do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state_limit: Option<f64>,
}

/// A simulation cannot be run, or the plant diverged.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// A list does not have one entry per state or channel.
    #[error("the plant has {expected} {what}, got {found}")]
    Count {
        /// What is counted.
        what: &'static str,
        /// Number that the plant has.
        expected: usize,
        /// Number that was given.
        found: usize,
    },
    /// A missing input cannot be simulated.
    #[error("input `{channel}` is missing at sample {k} ({time} s)")]
    MissingInput {
        /// Name of the channel.
        channel: String,
        /// Sample index.
        k: usize,
        /// Time of the sample, in seconds.
        time: f64,
    },
    /// A state or output left its limits.
    #[error("the plant diverged at sample {k} ({time} s): {signal} {index} is {value}")]
    Diverged {
        /// Sample index.
        k: usize,
        /// Time of the sample, in seconds.
        time: f64,
        /// `"state"` or `"output"`.
        signal: &'static str,
        /// Index of the state or output, from 0.
        index: usize,
        /// Value that was found.
        value: f64,
    },
    /// The plant has no parameters to move.
    #[error("{site} needs a plant with parameters, use `run_with_parameters`")]
    NoParameters {
        /// The faulty component.
        site: Site,
    },
    /// A fault is wrong.
    #[error(transparent)]
    Fault(#[from] FaultError),
    /// A noise is wrong.
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// The outputs do not make a record.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl Simulation {
    /// Drives a plant with sensor and actuator faults.
    ///
    /// The record holds the inputs that were commanded, not those that a faulty actuator made of
    /// them, and the outputs as the sensors show them, with noise first and faults on top.
    /// Output `k` belongs to the state before step `k`.
    ///
    /// # Errors
    ///
    /// Returns an error when a count does not fit the plant, an input is missing, noise or a
    /// fault is wrong, a fault is on a component, or the plant diverges.
    pub fn run(
        &self,
        plant: &(impl Plant<f64> + ?Sized),
        inputs: &Inputs,
        outputs: Vec<Channel>,
    ) -> Result<Record, SimulationError> {
        if let Some(fault) = self.faults.iter().find(|f| matches!(f.site, Site::Component(_))) {
            return Err(SimulationError::NoParameters { site: fault.site.clone() });
        }
        let mut run = Run::new(self, plant, inputs, &outputs)?;
        let mut y = Vec::with_capacity(inputs.len() * outputs.len());
        for k in 0..inputs.len() {
            y.extend_from_slice(run.step(k, plant)?);
        }
        record_of(inputs, outputs, y)
    }

    /// Drives a copy of a plant with faults of any kind.
    ///
    /// # Errors
    ///
    /// As [`Simulation::run`], but faults may be on components.
    pub fn run_with_parameters<P: Plant<f64> + Parameters + Clone>(
        &self,
        plant: &P,
        inputs: &Inputs,
        outputs: Vec<Channel>,
    ) -> Result<Record, SimulationError> {
        let names = plant.parameter_names();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut components =
            self.running(inputs, |site| matches!(site, Site::Component(_)), &names)?;
        let mut moving = plant.clone();
        let mut run = Run::new(self, plant, inputs, &outputs)?;
        let mut y = Vec::with_capacity(inputs.len() * outputs.len());
        for k in 0..inputs.len() {
            for (&index, faults) in &mut components {
                moving.set_parameter(index, with_faults(faults, plant.parameter(index)));
            }
            y.extend_from_slice(run.step(k, &moving)?);
        }
        record_of(inputs, outputs, y)
    }

    /// The faults on some kind of site, by the index of the signal they act on.
    fn running(
        &self,
        inputs: &Inputs,
        on: impl Fn(&Site) -> bool,
        names: &[&str],
    ) -> Result<FaultsByIndex, FaultError> {
        let mut by_index = FaultsByIndex::new();
        for fault in self.faults.iter().filter(|fault| on(&fault.site)) {
            let running = fault.start(inputs.time(0), inputs.ts())?;
            by_index.entry(fault.site.index_among(names)?).or_default().push(running);
        }
        Ok(by_index)
    }
}

/// The commanded inputs beside what the sensors showed.
fn record_of(
    inputs: &Inputs,
    outputs: Vec<Channel>,
    y: Vec<f64>,
) -> Result<Record, SimulationError> {
    let (channels, u) = (inputs.channels().to_vec(), inputs.values().to_vec());
    Ok(Record::new(channels, outputs, u, y, inputs.ts())?.starting_at(inputs.time(0)))
}

type FaultsByIndex = BTreeMap<usize, Vec<RunningFault>>;

fn with_faults(faults: &mut [RunningFault], v: f64) -> f64 {
    faults.iter_mut().fold(v, |v, fault| fault.next(v))
}

/// One simulation on its way: everything that changes from sample to sample.
struct Run<'a> {
    inputs: &'a Inputs,
    state_limit: f64,
    state_noise: Vec<Vec<f64>>,
    output_noise: Vec<Vec<f64>>,
    actuators: FaultsByIndex,
    sensors: FaultsByIndex,
    x: Vec<f64>,
    x_next: Vec<f64>,
    u: Vec<f64>,
    y: Vec<f64>,
}

impl<'a> Run<'a> {
    fn new(
        simulation: &Simulation,
        plant: &(impl Plant<f64> + ?Sized),
        inputs: &'a Inputs,
        outputs: &[Channel],
    ) -> Result<Self, SimulationError> {
        let (nx, io) = (plant.nx(), plant.io());
        expect_count("inputs", io.nu, inputs.channels().len())?;
        expect_count("outputs", io.ny, outputs.len())?;
        let x = if simulation.x0.is_empty() { vec![0.0; nx] } else { simulation.x0.clone() };
        expect_count("states", nx, x.len())?;
        let names = |channels: &'a [Channel]| channels.iter().map(|c| c.name.as_str()).collect();
        let input_names: Vec<&str> = names(inputs.channels());
        let output_names: Vec<&str> = outputs.iter().map(|c| c.name.as_str()).collect();
        let noise = |what, specs: &[SignalSpec], width| {
            if !specs.is_empty() {
                expect_count(what, width, specs.len())?;
            }
            specs
                .iter()
                .map(|spec| Ok(spec.values(inputs.len(), inputs.ts())?))
                .collect::<Result<_, SimulationError>>()
        };
        Ok(Self {
            inputs,
            state_limit: simulation.state_limit.unwrap_or(f64::INFINITY),
            state_noise: noise("states with noise", &simulation.state_noise, nx)?,
            output_noise: noise("outputs with noise", &simulation.output_noise, io.ny)?,
            actuators: simulation.running(
                inputs,
                |site| matches!(site, Site::Actuator(_)),
                &input_names,
            )?,
            sensors: simulation.running(
                inputs,
                |site| matches!(site, Site::Sensor(_)),
                &output_names,
            )?,
            x,
            x_next: vec![0.0; nx],
            u: vec![0.0; io.nu],
            y: vec![0.0; io.ny],
        })
    }

    /// Measures at sample `k`, then moves on to the next.
    fn step(
        &mut self,
        k: usize,
        plant: &(impl Plant<f64> + ?Sized),
    ) -> Result<&[f64], SimulationError> {
        let time = self.inputs.time(k);
        self.u.copy_from_slice(self.inputs.u(k));
        if let Some(missing) = self.u.iter().position(|u| !u.is_finite()) {
            let channel = self.inputs.channels()[missing].name.clone();
            return Err(SimulationError::MissingInput { channel, k, time });
        }
        for (&channel, faults) in &mut self.actuators {
            self.u[channel] = with_faults(faults, self.u[channel]);
        }
        expect_bounded(k, time, "state", &self.x, self.state_limit)?;
        plant.output(&self.x, &self.u, &mut self.y);
        expect_bounded(k, time, "output", &self.y, f64::INFINITY)?;
        for (y, noise) in self.y.iter_mut().zip(&self.output_noise) {
            *y += noise[k];
        }
        for (&channel, faults) in &mut self.sensors {
            self.y[channel] = with_faults(faults, self.y[channel]);
        }
        plant.advance(&self.x, &self.u, &mut self.x_next);
        for (x, noise) in self.x_next.iter_mut().zip(&self.state_noise) {
            *x += noise[k];
        }
        std::mem::swap(&mut self.x, &mut self.x_next);
        Ok(&self.y)
    }
}

fn expect_count(what: &'static str, expected: usize, found: usize) -> Result<(), SimulationError> {
    if expected == found { Ok(()) } else { Err(SimulationError::Count { what, expected, found }) }
}

fn expect_bounded(
    k: usize,
    time: f64,
    signal: &'static str,
    values: &[f64],
    limit: f64,
) -> Result<(), SimulationError> {
    match values.iter().position(|v| !v.is_finite() || limit < v.abs()) {
        None => Ok(()),
        Some(index) => {
            Err(SimulationError::Diverged { k, time, signal, index, value: values[index] })
        }
    }
}

#[cfg(test)]
mod tests;
