//! The changes that an effect makes to a model.

use super::error::PatchError;
use crate::{
    equation::Expr,
    model::{Definition, Delay, Draft, Input, Law, Model, NamedTable, Parameter, Sign, State},
};

/// One effect on its way into a model.
///
/// ```
/// use fd_sim::{equation::Expr, model::{Model, Parameter}, patch::Patch};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "slider"
/// sample_time = 0.01
/// parameters = { m = { unit = "kg", value = 2.0 } }
/// inputs = { u = { unit = "N" } }
/// states = { v = { unit = "m/s", initial = 0.0, derivative = "u/m" } }
/// outputs = { y = { unit = "m/s", value = "v" } }
/// sites = { rail = { unit = "N", enters = { v = "1/m" }, velocity = "v" } }
/// "#.parse()?;
/// let mut patch = Patch::of(&model);
/// patch.add_parameter(Parameter::new("f_c", "N", 0.3));
/// patch.add_force("rail", "friction", Expr::parse("-f_c*tanh(v/0.001)")?)?;
/// let patched = patch.finish()?;
/// assert_eq!(patched.states[0].law.expr().to_string(), "u/m + 1/m*friction");
/// assert_eq!(patched.definitions[0].value.to_string(), "-f_c*tanh(v/0.001)");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Patch {
    /// The model that is being changed.
    draft: Draft,
    /// What was added; it is not touched by wrapping.
    added: Draft,
}

impl Patch {
    /// A patch that changes nothing yet.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        Self { draft: (**model).clone(), added: Draft::default() }
    }

    /// A name that neither the model nor the patch has, `wish` if that is free.
    #[must_use]
    pub fn fresh_name(&self, wish: &str) -> String {
        self.draft.fresh_name_besides(&self.added, wish)
    }

    /// Adds a parameter, after those of the model.
    pub fn add_parameter(&mut self, parameter: Parameter) {
        self.added.parameters.push(parameter);
    }

    /// Adds a state of the plant, after those of the plant.
    pub fn add_state(&mut self, state: State) {
        self.added.states.push(state);
    }

    /// Adds an input from outside, after those of the model.
    pub fn add_input(&mut self, input: Input) {
        self.added.inputs.push(input);
    }

    /// Adds a named expression.
    pub fn add_definition(&mut self, name: impl Into<String>, value: Expr) {
        self.added.definitions.push(Definition { name: name.into(), value });
    }

    /// Adds a delayed expression.
    pub fn add_delay(&mut self, delay: Delay) {
        self.added.delays.push(delay);
    }

    /// Adds the set-valued sign of a velocity.
    pub fn add_sign(&mut self, sign: Sign) {
        self.added.signs.push(sign);
    }

    /// Adds a table.
    pub fn add_table(&mut self, table: NamedTable) {
        self.added.tables.push(table);
    }

    /// Lets the plant see `value`, under the name `applied`, wherever it saw the input. In `value`
    /// the name of the input means what arrives, after saturation. An output that is nothing but
    /// the input logs the command and still shows what arrives.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such input.
    pub fn wrap_input(
        &mut self,
        input: &str,
        applied: &str,
        value: Expr,
    ) -> Result<(), PatchError> {
        let known = self.draft.inputs.iter().map(|known| known.name.as_str());
        require("input", input, known)?;
        self.wrap(input, applied, value);
        Ok(())
    }

    /// Lets the plant see `value`, under the name `applied`, wherever it saw the parameter, such as
    /// `J*(1 + e)` for an error `e` of `J`. Limits of inputs and the controller keep the parameter.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such parameter.
    pub fn wrap_parameter(
        &mut self,
        parameter: &str,
        applied: &str,
        value: Expr,
    ) -> Result<(), PatchError> {
        let known = self.draft.parameters.iter().map(|known| known.name.as_str());
        require("parameter", parameter, known)?;
        self.wrap(parameter, applied, value);
        Ok(())
    }

    /// Lets the plant see `value`, under the name `applied`, wherever it saw the definition. In `value` the name
    /// of the definition means what that says.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such definition.
    pub fn wrap_definition(
        &mut self,
        definition: &str,
        applied: &str,
        value: Expr,
    ) -> Result<(), PatchError> {
        let known = self.draft.definitions.iter().map(|known| known.name.as_str());
        require("definition", definition, known)?;
        self.wrap(definition, applied, value);
        Ok(())
    }

    fn wrap(&mut self, name: &str, applied: &str, value: Expr) {
        let logged = Expr::name(name);
        let logs: Vec<usize> = (0..self.draft.outputs.len())
            .filter(|i| self.draft.outputs[*i].value == logged)
            .collect();
        for expr in self.draft.plant_expressions_mut() {
            *expr = expr.rename(name, applied);
        }
        for i in logs {
            self.draft.outputs[i].value = logged.clone();
        }
        self.add_definition(applied, value);
    }

    /// Lets the sensor show `value`. In `value` the name `measured` means what the output was
    /// before.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such output.
    pub fn wrap_output(
        &mut self,
        output: &str,
        measured: &str,
        value: Expr,
    ) -> Result<(), PatchError> {
        require("output", output, self.draft.outputs.iter().map(|known| known.name.as_str()))?;
        let mut outputs = self.draft.outputs.iter_mut();
        if let Some(output) = outputs.find(|known| known.name == output) {
            let before = std::mem::replace(&mut output.value, value);
            // What an earlier wrap has left is part of the model: definitions may be wrapped too.
            self.draft.definitions.push(Definition { name: measured.to_owned(), value: before });
        }
        Ok(())
    }

    /// Adds a generalised force, under the name `name`, at a site.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such site.
    pub fn add_force(&mut self, site: &str, name: &str, value: Expr) -> Result<(), PatchError> {
        self.add_definition(name, value);
        self.add_force_term(site, &Expr::name(name))
    }

    /// Adds a generalised force at a site, without a name of its own.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such site.
    pub(super) fn add_force_term(&mut self, site: &str, force: &Expr) -> Result<(), PatchError> {
        require("site", site, self.draft.sites.iter().map(|known| known.name.as_str()))?;
        let sites = self.draft.sites.iter().filter(|known| known.name == site);
        for (state, factor) in sites.flat_map(|site| site.enters.clone()).collect::<Vec<_>>() {
            self.add_to_law(&state, factor * force.clone())?;
        }
        Ok(())
    }

    /// Adds a term to the law of a state, in the unit of the law (that of the state per second for
    /// a derivative).
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such state.
    pub fn add_to_law(&mut self, state: &str, term: Expr) -> Result<(), PatchError> {
        require("state", state, self.draft.states.iter().map(|known| known.name.as_str()))?;
        if let Some(state) = self.draft.states.iter_mut().find(|known| known.name == state) {
            let before = std::mem::replace(state.law.expr_mut(), Expr::Number(0.0));
            *state.law.expr_mut() = before + term;
        }
        Ok(())
    }

    /// Replaces the law of a state; the old one is returned, to be used in the new one.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such state.
    pub fn replace_law(&mut self, state: &str, law: Law) -> Result<Law, PatchError> {
        let place = self.draft.states.iter().position(|known| known.name == state);
        let Some(place) = place else {
            return Err(unknown(
                "state",
                state,
                self.draft.states.iter().map(|known| known.name.as_str()),
            ));
        };
        Ok(std::mem::replace(&mut self.draft.states[place].law, law))
    }

    /// States the longest integration step, in seconds, instead of leaving it to the simulator; a shorter one stays.
    pub fn pin_step(&mut self, seconds: f64) {
        self.draft.step = Some(self.draft.step.map_or(seconds, |step| step.min(seconds)));
    }

    /// Puts everything together and checks it.
    ///
    /// # Errors
    ///
    /// Returns an error when the patched model is not correct, such as a name that is taken.
    pub fn finish(self) -> Result<Model, PatchError> {
        let Self { mut draft, added } = self;
        append(&mut draft, added);
        Ok(Model::try_from(draft)?)
    }
}

fn append(draft: &mut Draft, added: Draft) {
    draft.parameters.extend(added.parameters);
    draft.inputs.extend(added.inputs);
    draft.states.extend(added.states);
    draft.definitions.extend(added.definitions);
    draft.delays.extend(added.delays);
    draft.signs.extend(added.signs);
    draft.tables.extend(added.tables);
}

fn require<'a>(
    what: &'static str,
    name: &str,
    mut known: impl Iterator<Item = &'a str> + Clone,
) -> Result<(), PatchError> {
    let names = known.clone();
    if known.any(|known| known == name) { Ok(()) } else { Err(unknown(what, name, names)) }
}

fn unknown<'a>(what: &'static str, name: &str, known: impl Iterator<Item = &'a str>) -> PatchError {
    PatchError::Unknown { what, name: name.to_owned(), known: known.map(str::to_owned).collect() }
}
