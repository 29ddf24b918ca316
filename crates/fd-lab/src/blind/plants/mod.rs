//! The plants of the blind test, in our own right-hand sides: nothing of the simulator that the
//! diagnosis uses is used here, except to read names and numbers from the model files.

mod drives;
mod elsewhere;
mod engine17;
mod inner;
mod looped;
mod mechanics;
mod process;

use fd_sim::model::{LoadError, Model};

pub(super) use self::{
    inner::{Inner, inner},
    looped::{Looped, STABLE, Tuning, UNSTABLE, looped},
};
use super::{error::BlindError, excitation::Drive, kind::CaseKind};

/// A plant with its parameters set.
pub(super) trait Physics: Send {
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
type Build = fn(&[f64]) -> Result<Box<dyn Physics>, BlindError>;

/// A kind of plant.
#[derive(Clone, Copy)]
pub(super) struct Plant {
    pub name: &'static str,
    /// Text of the nominal model, or a function that makes it.
    model: fn() -> Result<Model, BlindError>,
    physics: Build,
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
    pub(super) fn model(&self) -> Result<Model, BlindError> {
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

    pub(super) fn physics(&self, p: &[f64]) -> Result<Box<dyn Physics>, BlindError> {
        (self.physics)(p)
    }
}

/// All plants.
pub(super) const ALL: [Plant; 11] = [
    mechanics::MASS_SPRING_DAMPER,
    mechanics::PENDULUM,
    mechanics::CART_POLE,
    mechanics::CART_POLE_BALANCED,
    drives::DC_DRIVE,
    drives::DC_DRIVE_CLOSED_LOOP,
    drives::TWO_MASS_DRIVE,
    process::TANKS,
    process::TWO_INPUT,
    process::TWO_SPOOL_ENGINE,
    engine17::ENGINE17,
];

/// Plants of logs as people have them only.
const ELSEWHERE: [Plant; 4] =
    [elsewhere::SERVO, elsewhere::STANDING_PENDULUM, elsewhere::LEVITATION, elsewhere::TWO_FILTERS];

/// The plant of a name.
pub(super) fn plant(name: &str) -> Option<&'static Plant> {
    ALL.iter().chain(&ELSEWHERE).find(|plant| plant.name == name)
}

/// The plants of a kind of case.
pub(super) fn of_kind(kind: CaseKind) -> Vec<&'static Plant> {
    let looped = |all: &'static [Looped]| all.iter().map(|looped| looped.plant).collect();
    match kind {
        CaseKind::Unstable | CaseKind::UnstableNone => looped(&UNSTABLE),
        CaseKind::Loop | CaseKind::LoopNone => looped(&STABLE),
        CaseKind::Inside => {
            ALL.iter().chain(&ELSEWHERE).filter(|plant| !inner(plant).is_empty()).collect()
        }
        // A loop of the model is no matter of these classes, and the states of the large engine
        // are not those of its model.
        kind if !kind.is_plain() => {
            let others = ["dc-drive-closed-loop", "cart-pole-balanced", "engine17"];
            ALL.iter().filter(|plant| !others.contains(&plant.name)).collect()
        }
        _ => ALL.iter().collect(),
    }
}

fn parse(text: &str, file: &str) -> Result<Model, BlindError> {
    text.parse().map_err(|error| BlindError::Model {
        error: Box::new(LoadError::Model { file: file.to_owned(), error }),
    })
}

/// A plant whose equations are plain functions of its parameters.
#[derive(Clone)]
struct Equations {
    p: Vec<f64>,
    laws: Laws,
}

type Rates = fn(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]);
type Outputs = fn(p: &[f64], x: &[f64], u: &[f64], y: &mut [f64]);
type Motion = fn(x: &[f64], site: usize) -> [Option<f64>; 2];
type Control = fn(p: &[f64], memory: &mut [f64], y: &[f64], reference: &[f64], u: &mut [f64]);

#[derive(Clone, Copy)]
struct Laws {
    rates: Rates,
    outputs: Outputs,
    motion: Motion,
    control: Control,
    memory: usize,
}

impl Laws {
    const fn open(rates: Rates, outputs: Outputs, motion: Motion) -> Self {
        Self { rates, outputs, motion, control: no_control, memory: 0 }
    }

    fn at(self, p: &[f64]) -> Box<dyn Physics> {
        Box::new(Equations { p: p.to_vec(), laws: self })
    }
}

/// Without a controller the references are the commands.
fn no_control(_: &[f64], _: &mut [f64], _: &[f64], reference: &[f64], u: &mut [f64]) {
    u.copy_from_slice(reference);
}

impl Physics for Equations {
    fn set(&mut self, p: &[f64]) {
        self.p.copy_from_slice(p);
    }

    fn rates(&self, x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
        (self.laws.rates)(&self.p, x, u, f, dx);
    }

    fn outputs(&self, x: &[f64], u: &[f64], y: &mut [f64]) {
        (self.laws.outputs)(&self.p, x, u, y);
    }

    fn motion(&self, x: &[f64], site: usize) -> [Option<f64>; 2] {
        (self.laws.motion)(x, site)
    }

    fn control(&self, memory: &mut [f64], y: &[f64], reference: &[f64], u: &mut [f64]) {
        (self.laws.control)(&self.p, memory, y, reference, u);
    }

    fn memory(&self) -> usize {
        self.laws.memory
    }
}
