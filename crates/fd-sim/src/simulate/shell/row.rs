//! A shell around a simulator that needs to know which sample of which log it is at.

use fd_model::SampleTime;

use super::{Shell, ShellSimulator, names::Names, wiring::Wiring};
use crate::{
    equation::Expr,
    model::{Input, Law, Model, ModelError, State},
    simulate::{Nominal, SimulateError, Simulator},
    stand_in::{Driven, ROW},
};

impl Shell {
    /// The same shell around a simulator that has the row of a log as one more input, the last one.
    pub(crate) fn with_row(&self, inside: Box<dyn Simulator>) -> Result<Self, ModelError> {
        let mut names = self.names.clone();
        names.integrals.push(integral());
        let model = with_row(&self.model, &self.names)?;
        Ok(Self { inside, model, names, stand_in: None })
    }

    /// A simulator of a model of the shell that knows nothing of rows.
    pub(crate) fn patched_with_row(
        &self,
        model: &Model,
        ts: SampleTime,
    ) -> Result<Box<dyn Simulator>, SimulateError> {
        self.patched(&self.told_the_row(model)?, ts)
    }

    /// What the simulator inside is given in a run of a `model` of the shell that knows nothing of rows, with the values
    /// that the model states, from the states `x0` on, through inputs `u` of which the last is the row. `None` where the
    /// run diverges.
    pub(crate) fn driven(
        &self,
        model: &Model,
        ts: SampleTime,
        [x0, u]: [&[f64]; 2],
        first: u64,
    ) -> Result<Option<Driven>, SimulateError> {
        let model = self.told_the_row(model)?;
        let wiring = Wiring::new(&model, &self.names)?;
        let mut simulator = ShellSimulator::new(self.inside.boxed(), &model, &wiring, ts)?;
        Ok(simulator.driven([&model.nominal(), x0, u], first).map(Driven::without_rows))
    }

    /// The model with the row as one more input.
    fn told_the_row(&self, model: &Model) -> Result<Model, ModelError> {
        let names = Names {
            integrals: self.names.integrals[..self.names.integrals.len() - 1].to_vec(),
            ..self.names.clone()
        };
        with_row(model, &names)
    }
}

/// The model with the row as one more input, which is passed on.
fn with_row(model: &Model, names: &Names) -> Result<Model, ModelError> {
    let mut draft = model.clone().into_draft();
    let row = Input { name: ROW.to_owned(), unit: "1".to_owned(), saturation: None };
    draft.inputs.insert(names.integrals.len(), row);
    let law = Law::Derivative(Expr::name(ROW));
    let (name, unit) = (integral(), "s".to_owned());
    draft.states.push(State { name, unit, initial: 0.0, tolerance: None, law });
    Model::try_from(draft)
}

fn integral() -> String {
    format!("{ROW}_integral")
}
