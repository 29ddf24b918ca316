//! A shell as the model of a plant that effects are spliced into.

use fd_model::SampleTime;

use super::{Shell, ShellSimulator, scales, wiring::Wiring};
use crate::{
    model::Model,
    scales::ReplayScales,
    simulate::{Nominal, SimulateError, Simulator},
};

impl Nominal for Shell {
    fn model(&self) -> &Model {
        &self.model
    }

    fn patched(&self, model: &Model, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError> {
        let wiring = Wiring::new(model, &self.names)?;
        let simulator = ShellSimulator::new(self.inside.boxed(), model, &wiring, ts)?;
        let stand_in = self.stand_in.as_ref().map(|shell| shell.patched_with_row(model, ts));
        Ok(Box::new(simulator.with_stand_in(stand_in.transpose()?)))
    }

    fn keeps_step(&self) -> bool {
        true
    }

    fn scales(
        &self,
        ts: SampleTime,
        u: &[f64],
        samples: usize,
    ) -> Result<ReplayScales, SimulateError> {
        let simulator = self.simulator(ts)?;
        Ok(scales::measure(self, simulator, u, samples))
    }
}
