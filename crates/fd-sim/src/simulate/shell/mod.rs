//! A shell of equations around a simulator that can only be stepped, so that effects can be spliced in.
//!
//! The model of the shell has the inputs of the simulator inside, and its raw outputs as further
//! inputs; its outputs pass these through. Effects splice into the shell as into any model:
//!
//! * **Inputs.** For each input `u` the shell integrates what the plant sees, `u_integral' = u`. An effect
//!   wraps `u` there. The simulator inside gets the mean over its step, which is the increment of the integral;
//!   delays by fractions of a step work. A value that does not change within a step is its own mean and is not
//!   integrated, so a shell without effects is bit-identical to the simulator inside.
//! * **Outputs.** Sensors wrap the raw outputs.
//! * **Parameters** of the simulator inside are those of the shell, each handed on by a definition
//!   `p_inside = p`, in which an error of the parameter wraps it.
//! * **Native effects** of the simulator inside are parameters of it that the shell does not have: a definition keeps
//!   each at its neutral value, `q = 0`, and hands that on, `q_inside = q`. A candidate wraps the definition.
//! * **Ports** are sites. A force enters the state `port_impulse`, of which the increment is the mean
//!   force over a step. Position and velocity are raw outputs that the user names, as they are at
//!   the start of the step.
//!
//! The simulator inside sees inputs and forces that are held over its step. Where that is too
//! coarse (friction that stops a fast motion), give it a step that is a whole fraction of the
//! sample time of the log; the shell steps it as often as needed.
//!
//! *When not to use:* for a plant whose equations are known. Friction that depends on load, swinging
//! appendages, coupling to inner states and stores that overflow need equations.

mod around;
mod build;
mod lane;
mod names;
mod nominal;
mod part;
mod prune;
mod row;
mod run;
mod scales;
mod wiring;

use std::sync::Arc;

use fd_model::{SampleTime, nearest};

pub use self::run::ShellSimulator;
use self::{build::build, names::Names, wiring::Wiring};
use super::{NativeEffect, SimulateError, Simulator};
use crate::{
    equation::Expr,
    model::{Mistake, Model, ModelError, Site},
};

/// A simulator of which only inputs, outputs, exposed parameters and force ports are known, to be
/// diagnosed.
///
/// ```
/// use faer::mat;
/// use fd_model::{Channel, Discrete, SampleTime, StateSpace};
/// use fd_sim::{
///     equation::Expr,
///     patch::Patch,
///     simulate::{BlackBox, Nominal, Shell, Simulator},
/// };
///
/// let ts = SampleTime::new(0.1)?;
/// let lag = StateSpace::new(mat![[0.5]], mat![[0.5]], mat![[1.0]], mat![[0.0]], Discrete { ts })?;
/// let (u, y) = (vec![Channel::new("u", "V")], vec![Channel::new("y", "V")]);
/// let shell = Shell::new("black box", Box::new(BlackBox::discrete(&lag, u, y)?))?
///     .with_noise(&[Some(0.01)]);
/// assert_eq!(shell.model().outputs[0].value.to_string(), "y_raw");
///
/// // An actuator that never gives more than half a volt.
/// let mut patch = Patch::of(shell.model());
/// patch.wrap_input("u", "limited", Expr::parse("min(u, 0.5)")?)?;
/// let mut limited = shell.patched(&patch.finish()?, ts)?;
/// let mut y = [0.0; 4];
/// limited.simulate(&[], &[0.0], &[0.0, 1.0, 1.0, 1.0], &mut y);
/// assert_eq!(y, [0.0, 0.0, 0.25, 0.375]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Shell {
    inside: Box<dyn Simulator>,
    model: Model,
    names: Names,
    /// What lends its slopes to fits of the simulator.
    stand_in: Option<Arc<Shell>>,
}

impl Shell {
    /// A shell around a simulator. Names that cannot stand in an expression are changed in the
    /// model; logs keep the names of the simulator.
    ///
    /// # Errors
    ///
    /// Returns an error when the simulator has no outputs, or a parameter with a value, tolerance
    /// or bounds that are not in order.
    pub fn new(name: &str, inside: Box<dyn Simulator>) -> Result<Self, ModelError> {
        let (model, names) = build(name, &*inside)?;
        Ok(Self { inside, model, names, stand_in: None })
    }

    /// States the standard deviation of the noise of each output, in its unit. Outputs beyond the
    /// end of the list keep what they have.
    #[must_use]
    pub fn with_noise(mut self, noise: &[Option<f64>]) -> Self {
        let mut draft = self.model.clone().into_draft();
        for (output, noise) in draft.outputs.iter_mut().zip(noise) {
            output.noise = noise.filter(|noise| noise.is_finite() && 0.0 <= *noise);
        }
        // Nothing else has changed, and the noise is in order.
        self.model = Model::try_from(draft).unwrap_or(self.model);
        self
    }

    /// Names the outputs that are the position and the velocity of what the force at a port moves.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such port or output.
    pub fn with_motion(
        mut self,
        port: &str,
        position: Option<&str>,
        velocity: Option<&str>,
    ) -> Result<Self, ModelError> {
        let ports: Vec<&str> =
            self.inside.ports().iter().map(|port| port.channel.name.as_str()).collect();
        let outputs: Vec<&str> =
            self.inside.outputs().iter().map(|output| output.name.as_str()).collect();
        let raw = |name: Option<&str>| {
            let place = name.map(|name| place("outputs", name, &outputs)).transpose();
            Ok::<_, ModelError>(place?.map(|i| Expr::name(&self.names.raw[i])))
        };
        let (port, position, velocity) =
            (place("ports", port, &ports)?, raw(position)?, raw(velocity)?);
        let mut draft = self.model.into_draft();
        let site: &mut Site = &mut draft.sites[port];
        (site.position, site.velocity) = (position, velocity);
        self.model = Model::try_from(draft)?;
        Ok(self)
    }

    /// Another model of this shell: with other tolerances or noise, or with effects in it.
    ///
    /// # Errors
    ///
    /// Returns an error when it is not that of this shell.
    pub fn with_model(mut self, model: Model) -> Result<Self, SimulateError> {
        Wiring::new(&model, &self.names)?;
        self.model = model;
        Ok(self)
    }

    /// Lends fits of the simulator the slopes of a stand-in, a shell that is told the row of a log.
    #[must_use]
    pub(crate) fn with_stand_in(self, stand_in: Self) -> Self {
        Self { stand_in: Some(Arc::new(stand_in)), ..self }
    }

    /// Steps of the simulator inside per sample.
    pub(crate) fn steps(&self, ts: SampleTime) -> Result<usize, SimulateError> {
        run::steps(self.inside.ts(), ts)
    }

    /// Effects that the simulator inside has in itself, each with the definition of the model that keeps it at rest.
    pub fn natives(&self) -> impl Iterator<Item = (&str, &NativeEffect)> {
        self.names.resting.iter().map(|(name, _)| name.as_str()).zip(self.inside.natives())
    }

    /// Values of the parameters of the simulator inside, in its order, when those of a model of this shell have the
    /// values that it states.
    ///
    /// # Errors
    ///
    /// Returns an error when the model is not that of this shell.
    pub fn handed_on(&self, model: &Model) -> Result<Vec<f64>, SimulateError> {
        let program = Wiring::new(model, &self.names)?.parameters;
        let mut workspace = program.workspace();
        let theta = model.nominal();
        workspace.slow_mut()[..theta.len()].copy_from_slice(&theta);
        program.prepare(&mut workspace);
        let mut values = vec![0.0; self.names.handed_on.len()];
        program.run(&mut workspace, &mut values);
        Ok(values)
    }

    /// Whether a model of this shell passes inputs, forces and outputs on as they are: what it changes, if anything,
    /// are parameters of the simulator inside.
    ///
    /// # Errors
    ///
    /// Returns an error when the model is not that of this shell.
    pub fn passes_on(&self, model: &Model) -> Result<bool, SimulateError> {
        let wiring = Wiring::new(model, &self.names)?;
        Ok(wiring.before.is_none() && wiring.after.is_none())
    }

    /// The simulator inside.
    #[must_use]
    pub fn inside(&self) -> &dyn Simulator {
        &*self.inside
    }
}

fn place(room: &str, name: &str, known: &[&str]) -> Result<usize, ModelError> {
    known.iter().position(|known| *known == name).ok_or_else(|| {
        let nearest = nearest(name, known.iter().copied());
        ModelError::new(room, Mistake::UnknownName { name: name.to_owned(), nearest })
    })
}
