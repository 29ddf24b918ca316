//! Any plant that steps, as a simulator.

use std::sync::Arc;

use fd_core::{Heap, Shape, ShapeError, StateVisitor, stage::Plant};
use fd_model::{Channel, Continuous, Discrete, Lti, ModelError, SampleTime, StateSpace};

use super::simulator::{Initial, Port, Simulator};
use crate::model::Parameter;

/// A simulator that only steps: no parameters, no ports, inputs held between samples.
///
/// ```
/// use faer::mat;
/// use fd_sim::simulate::{BlackBox, Outcome, Simulator};
/// use fd_model::{Channel, Discrete, SampleTime, StateSpace};
///
/// let ts = SampleTime::new(0.1)?;
/// let lag = StateSpace::new(mat![[0.5]], mat![[0.5]], mat![[1.0]], mat![[0.0]], Discrete { ts })?;
/// let channels = |prefix| Channel::numbered(prefix, 1);
/// let mut simulator = BlackBox::discrete(&lag, channels("u"), channels("y"))?;
/// let mut y = [0.0; 3];
/// assert_eq!(simulator.simulate(&[], &[0.0], &[1.0; 3], &mut y), Outcome::Complete);
/// assert_eq!(y, [0.0, 0.5, 0.75]);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct BlackBox {
    plant: Arc<dyn Plant<f64>>,
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
    initial: Vec<Initial>,
    ts: SampleTime,
    x: Vec<f64>,
    x_next: Vec<f64>,
}

impl BlackBox {
    /// A simulator of a plant. Its initial state is zero and known, unless
    /// [`with_initial`](Self::with_initial) says otherwise.
    ///
    /// # Errors
    ///
    /// Returns an error when the numbers of channels are not those of the plant.
    pub fn new(
        plant: impl Plant<f64> + 'static,
        inputs: Vec<Channel>,
        outputs: Vec<Channel>,
        ts: SampleTime,
    ) -> Result<Self, ModelError> {
        let (nx, io) = (plant.nx(), plant.io());
        let sizes =
            [("input channels", io.nu, inputs.len()), ("output channels", io.ny, outputs.len())];
        for (role, expected, found) in sizes {
            if expected != found {
                let (expected, found) = (Shape::new(expected, 1), Shape::new(found, 1));
                return Err(ShapeError { role, expected, found }.into());
            }
        }
        let state = |channel| Initial { channel, value: 0.0, tolerance: None };
        Ok(Self {
            initial: Channel::numbered("x", nx).into_iter().map(state).collect(),
            plant: Arc::new(plant),
            inputs,
            outputs,
            ts,
            x: vec![0.0; nx],
            x_next: vec![0.0; nx],
        })
    }

    /// A simulator of a discrete linear model.
    ///
    /// # Errors
    ///
    /// As [`BlackBox::new`].
    pub fn discrete(
        model: &StateSpace<Discrete>,
        inputs: Vec<Channel>,
        outputs: Vec<Channel>,
    ) -> Result<Self, ModelError> {
        let plant: Lti<f64, Heap> = model.freeze()?;
        Self::new(plant, inputs, outputs, model.domain().ts)
    }

    /// A simulator of a continuous linear model, sampled with inputs held between samples.
    ///
    /// # Errors
    ///
    /// As [`BlackBox::new`].
    pub fn continuous(
        model: &StateSpace<Continuous>,
        inputs: Vec<Channel>,
        outputs: Vec<Channel>,
        ts: SampleTime,
    ) -> Result<Self, ModelError> {
        Self::discrete(&model.sample_zoh(ts)?, inputs, outputs)
    }

    /// Says what is known of the initial state.
    ///
    /// # Errors
    ///
    /// Returns an error when the number of states is not that of the plant.
    pub fn with_initial(mut self, initial: Vec<Initial>) -> Result<Self, ModelError> {
        let (expected, found) = (Shape::new(self.x.len(), 1), Shape::new(initial.len(), 1));
        if expected != found {
            return Err(ShapeError { role: "initial state", expected, found }.into());
        }
        self.initial = initial;
        Ok(self)
    }
}

impl Simulator for BlackBox {
    fn ts(&self) -> SampleTime {
        self.ts
    }

    fn inputs(&self) -> &[Channel] {
        &self.inputs
    }

    fn outputs(&self) -> &[Channel] {
        &self.outputs
    }

    fn parameters(&self) -> &[Parameter] {
        &[]
    }

    fn initial(&self) -> &[Initial] {
        &self.initial
    }

    fn ports(&self) -> &[Port] {
        &[]
    }

    fn start(&mut self, _theta: &[f64], x0: &[f64], _first: u64) {
        self.x.copy_from_slice(x0);
    }

    fn step(&mut self, u: &[f64], _u_next: &[f64], _f: &[f64], y: &mut [f64]) {
        self.plant.output(&self.x, u, y);
        self.plant.advance(&self.x, u, &mut self.x_next);
        std::mem::swap(&mut self.x, &mut self.x_next);
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> bool {
        self.plant.output(&self.x, u, y);
        true
    }

    fn state(&self) -> &[f64] {
        &self.x
    }

    fn visit_memory(&mut self, visitor: &mut dyn StateVisitor<f64>) -> bool {
        visitor.reals_with_holes("states of the black box", &mut self.x);
        true
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }
}
