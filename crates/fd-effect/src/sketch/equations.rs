//! States, delays and definitions that an effect adds.

use fd_sim::{
    equation::{Comparison, Cond, Expr},
    model::{Delay, Law, Sign, State},
};

use super::Sketch;
use crate::Reason;

impl Sketch<'_> {
    /// Adds a memory: a state that changes at the end of each integration step, to what
    /// [`becomes`](Self::becomes) says. The local name stands for its value at the start of the
    /// step, which is the template `at_first` in the first step of a run.
    #[must_use]
    pub fn memory(mut self, local: &str, name: &str, unit: &str, at_first: &str) -> Self {
        let state = self.fresh(name);
        let is_first = Cond::compare(Comparison::Greater, Expr::name("first"), Expr::Number(0.0));
        let value = Expr::choice(is_first, self.expr(at_first), Expr::name(&state));
        self.add_state(&state, unit, Law::Update(value.clone()));
        self.memories.push((local.to_owned(), state));
        self.bind(local, value)
    }

    /// States what a memory becomes at the end of a step, from values at its start.
    #[must_use]
    pub fn becomes(mut self, local: &str, template: &str) -> Self {
        let law = Law::Update(self.expr(template));
        self.set_law(local, law);
        self
    }

    /// Adds a state, 0 at the start of a run, with the derivative that [`moves`](Self::moves) says.
    #[must_use]
    pub fn dynamic(mut self, local: &str, name: &str, unit: &str) -> Self {
        let state = self.fresh(name);
        self.add_state(&state, unit, Law::Derivative(Expr::Number(0.0)));
        self.memories.push((local.to_owned(), state.clone()));
        self.bind(local, Expr::name(state))
    }

    /// States the derivative of a state.
    #[must_use]
    pub fn moves(mut self, local: &str, derivative: &str) -> Self {
        let law = Law::Derivative(self.expr(derivative));
        self.set_law(local, law);
        self
    }

    fn set_law(&mut self, local: &str, law: Law) {
        let memory = self.memories.iter().find(|(known, _)| known == local);
        match memory.and_then(|(_, name)| self.states.iter_mut().find(|s| s.name == *name)) {
            Some(state) => state.law = law,
            None => self.fail(Reason::Missing("such memory")),
        }
    }

    fn add_state(&mut self, name: &str, unit: &str, law: Law) {
        let unit = if unit.is_empty() { "1" } else { unit }.to_owned();
        self.states.push(State { name: name.to_owned(), unit, initial: 0.0, tolerance: None, law });
    }

    /// Adds the value of a template some time (a template of parameters, in s) ago.
    #[must_use]
    pub fn delay(mut self, local: &str, name: &str, value: &str, time: &str) -> Self {
        let name = self.fresh(name);
        let (value, time) = (self.expr(value), self.expr(time));
        self.patch.add_delay(Delay { name: name.clone(), value, time });
        self.bind(local, Expr::name(name))
    }

    /// Adds the set-valued sign of the velocity that is a template.
    #[must_use]
    pub fn sign(mut self, local: &str, name: &str, velocity: &str) -> Self {
        let name = self.fresh(name);
        let velocity = self.expr(velocity);
        self.patch.add_sign(Sign { name: name.clone(), velocity });
        self.bind(local, Expr::name(name))
    }

    /// Adds what switches from 0 to 1 at `since`, a template in s: the share of the integration step in which it is 1, so that
    /// what acts in a step adds up exactly.
    #[must_use]
    pub fn onset(self, local: &str, name: &str, since: &str) -> Self {
        // What is known at the start of a step is the share of the next one.
        self.memory(local, name, "1", &format!("clamp((t + dt - ({since}))/dt, 0, 1)"))
            .becomes(local, &format!("clamp((t + 2*dt - ({since}))/dt, 0, 1)"))
    }

    /// Says a strength as a person would, in the coordinate of the plots: a definition beside the parameter of the strength,
    /// `name_at`, which the law does not use; of two limits the lower one is `name_from`.
    #[must_use]
    pub(crate) fn said(mut self, local: &str, ends: [Option<&str>; 2]) -> Self {
        let parameter = self.expr(local).to_string();
        for (suffix, template) in ["from", "at"].into_iter().zip(ends) {
            if let Some(template) = template {
                let value = self.expr(template);
                self.patch.add_definition(format!("{parameter}_{suffix}"), value);
            }
        }
        self
    }

    /// Adds a named expression.
    #[must_use]
    pub fn define(mut self, local: &str, name: &str, template: &str) -> Self {
        let name = self.fresh(name);
        let value = self.expr(template);
        self.patch.add_definition(name.clone(), value);
        self.bind(local, Expr::name(name))
    }
}
