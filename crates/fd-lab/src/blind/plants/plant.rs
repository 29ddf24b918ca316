//! A plant: the model file that it is told by, and its own right-hand sides.

use fd_sim::model::{LoadError, Model};

use crate::blind::{error::BlindError, excitation::Drive};

/// A plant with its parameters set.
pub(in crate::blind) trait Physics: Send {
    /// Sets the parameters, in the order of the model file.
    fn set(&mut self, p: &[f64]);

    /// Rates of the states at inputs `u` and forces `f`, one per site.
    fn rates(&self, x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]);

    /// Outputs, without what sensors do to them.
    fn outputs(&self, x: &[f64], u: &[f64], y: &mut [f64]);

    /// Position and velocity at a site, both linear in the states.
    fn motion(&self, x: &[f64], site: usize) -> [Option<f64>; 2];

    /// A sampled controller: commands from measured outputs and references; moves its memory on.
    fn control(&self, memory: &mut [f64], y: &[f64], reference: &[f64], u: &mut [f64]);

    /// Size of the controller's memory.
    fn memory(&self) -> usize {
        0
    }

    /// The state to begin with, from the initial states of the model.
    fn begin(&self, x0: &[f64]) -> Vec<f64> {
        x0.to_vec()
    }
}

/// Makes a plant with its parameters set.
pub(super) type Build = fn(&[f64]) -> Result<Box<dyn Physics>, BlindError>;

/// A kind of plant.
#[derive(Clone, Copy)]
pub(in crate::blind) struct Plant {
    pub name: &'static str,
    /// Text of the nominal model, or a function that makes it.
    pub(super) model: fn() -> Result<Model, BlindError>,
    pub(super) physics: Build,
    /// One per external input.
    pub drives: &'static [Drive],
    /// Whether the controller, if there is one, sees the noise that is logged.
    pub noise_in_loop: bool,
    /// Longest integration step of the truth, in seconds.
    pub step: f64,
    /// Whether something turns around at its sites, as friction needs it.
    pub reverses: bool,
    /// Share of the cases.
    pub weight: usize,
}

impl Plant {
    /// The nominal model as a user would write it: no parameter is known better than to within
    /// 3 % unless the file says so, and the initial states within their tolerance.
    pub(in crate::blind) fn model(&self) -> Result<Model, BlindError> {
        let mut draft = (self.model)()?.into_draft();
        for parameter in &mut draft.parameters {
            parameter.tolerance = parameter.tolerance.min(0.03);
        }
        // The controller passes the noise of the speed sensor on to the voltage.
        if self.noise_in_loop {
            for output in draft.outputs.iter_mut().filter(|output| output.name == "voltage") {
                output.noise = Some(0.009);
            }
        }
        Model::try_from(draft).map_err(|error| BlindError::Model {
            error: Box::new(LoadError::Model { file: self.name.to_owned(), error }),
        })
    }

    pub(in crate::blind) fn physics(&self, p: &[f64]) -> Result<Box<dyn Physics>, BlindError> {
        (self.physics)(p)
    }
}

/// The model of a file.
pub(super) fn parse(text: &str, file: &str) -> Result<Model, BlindError> {
    text.parse().map_err(|error| BlindError::Model {
        error: Box::new(LoadError::Model { file: file.to_owned(), error }),
    })
}
