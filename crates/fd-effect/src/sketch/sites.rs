//! Where an effect meets the model.

use fd_sim::{equation::Expr, model::Model, patch::PatchError};

use super::Sketch;
use crate::SiteRef;

impl Sketch<'_> {
    /// Lets the plant see the value of a template instead of the input, or the signal, `u`.
    #[must_use]
    pub fn wrap_input(mut self, template: &str) -> Self {
        let (applied, value) = (self.fresh("applied"), self.expr(template));
        let result = match self.candidate.site {
            SiteRef::Signal(..) => self.patch.wrap_definition(&self.prefix, &applied, value),
            _ => self.patch.wrap_input(&self.prefix, &applied, value),
        };
        self.keep(result)
    }

    /// Lets the sensor show the value of a template instead of `y`.
    #[must_use]
    pub fn wrap_output(mut self, template: &str) -> Self {
        let (measured, value) = (self.expr("y").to_string(), self.expr(template));
        let result = self.patch.wrap_output(&self.prefix, &measured, value);
        self.keep(result)
    }

    /// Lets an output show what it would if states were less by templates.
    #[must_use]
    pub(crate) fn shift_output(
        mut self,
        output: &SiteRef,
        nominal: &Model,
        less: &[(String, &str)],
    ) -> Self {
        let name = output.name().unwrap_or_default();
        let value = nominal.outputs.iter().find(|known| known.name == name).map(|o| &o.value);
        let Some(value) = value else { return self };
        let less: Vec<(&str, Expr)> =
            less.iter().map(|(state, by)| (state.as_str(), self.expr(by))).collect();
        let measured = self.patch.fresh_name(&format!("{name}_measured"));
        // Exactly nothing where both are the same.
        let change = moved(nominal, value, &less) - value.clone();
        let result = self.patch.wrap_output(name, &measured, Expr::name(&measured) + change);
        self.keep(result)
    }

    /// Lets the plant see the value of a template instead of the parameter `p`.
    #[must_use]
    pub fn wrap_parameter(mut self, template: &str) -> Self {
        let (real, value) = (self.fresh("real"), self.expr(template));
        let result = self.patch.wrap_parameter(&self.prefix, &real, value);
        self.keep(result)
    }

    /// Lets the simulator have the value of a template instead of `p`, at which one of its own effects rests.
    #[must_use]
    pub(crate) fn wrap_native(mut self, template: &str) -> Self {
        let (rest, applied, value) =
            (self.expr("p").to_string(), self.fresh("native"), self.expr(template));
        let result = self.patch.wrap_definition(&rest, &applied, value);
        self.keep(result)
    }

    /// Adds a force at the site.
    #[must_use]
    pub fn force(mut self, name: &str, template: &str) -> Self {
        let (name, value) = (self.fresh(name), self.expr(template));
        let result = self.patch.add_force(&self.prefix, &name, value);
        self.keep(result)
    }

    /// Adds a force at the site that works against `v` or `x`, to which the template is positive.
    #[must_use]
    pub fn resist(mut self, name: &str, template: &str) -> Self {
        let (name, value) = (self.fresh(name), self.expr(template));
        let value = self.force.map_or_else(|| -value.clone(), |force| force.against(value.clone()));
        let result = self.patch.add_force(&self.prefix, &name, value);
        self.keep(result)
    }

    /// Adds a force at another site.
    #[must_use]
    pub fn force_at(mut self, site: &str, name: &str, template: &str) -> Self {
        let (name, value) = (self.fresh(name), self.expr(template));
        let result = self.patch.add_force(site, &name, value);
        self.keep(result)
    }

    fn keep(mut self, result: Result<(), PatchError>) -> Self {
        if let Err(error) = result {
            self.fail(error.into());
        }
        self
    }
}

/// An expression with less of some states, in the definitions that it uses as well.
fn moved(model: &Model, expr: &Expr, less: &[(&str, Expr)]) -> Expr {
    expr.substitute(&|name| {
        let state = less.iter().find(|(state, _)| *state == name);
        state.map(|(_, by)| Expr::name(name) - by.clone()).or_else(|| {
            let definition = model.definitions.iter().find(|known| known.name == name)?;
            let changed = moved(model, &definition.value, less);
            (changed != definition.value).then_some(changed)
        })
    })
}
