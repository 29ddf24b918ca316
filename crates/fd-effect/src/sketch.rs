//! The bookkeeping of a candidate: names, units, bounds, patches.

mod equations;
mod remarks;
mod sites;

use fd_sim::scales::{ForceScale, ReplayScales};
use fd_sim::{
    equation::Expr,
    model::{Definition, Model, Parameter, State},
    patch::Patch,
};

use super::{
    candidate::{Candidate, Effect, EffectParameter, InAnotherRun, Kind, NotTestable, Reason},
    site::{Side, SiteRef},
};

/// A candidate in the making.
///
/// Equations are templates, in which short local names stand for what they are bound to: `u` for
/// the input, `v` and `x` for velocity and position of a site, `y` for what a sensor measures, `p`
/// for a parameter, and whatever the sketch adds. `t`, `dt`, `first` and `pi` mean what they mean
/// in models. Bounds and starts are in units of the scale of their parameter.
///
/// What goes wrong on the way is kept, and [`Sketch::finish`] returns it. See [`Effect`] for an
/// example.
#[derive(Clone, Debug)]
pub struct Sketch<'a> {
    candidate: Candidate,
    patch: Patch,
    /// Local names and what they stand for.
    bound: Vec<(String, Expr)>,
    /// Beginning of the names of everything that is added.
    prefix: String,
    /// States to be added.
    states: Vec<State>,
    /// Local names of memories and their states.
    memories: Vec<(String, String)>,
    force: Option<&'a ForceScale>,
    problem: Option<Reason>,
}

impl<'a> Sketch<'a> {
    /// An effect between an input and the plant; `u` is what arrives at the input.
    ///
    /// # Panics
    ///
    /// Panics when there is no such input, as the other constructors do for theirs.
    pub fn of_input(
        effect: &dyn Effect,
        law: &'static str,
        nominal: &'a Model,
        scales: &'a ReplayScales,
        index: usize,
    ) -> Self {
        let name = nominal.inputs[index].name.clone();
        let site = SiteRef::Input(index, name.clone());
        Self::new(effect, law, nominal, scales, site, Side::Input).bind("u", Expr::name(name))
    }

    /// An effect on a signal inside the model, by its place in [`ReplayScales::signals`]; `u` is the signal as its
    /// definition has it.
    pub fn of_signal(
        effect: &dyn Effect,
        law: &'static str,
        nominal: &'a Model,
        scales: &'a ReplayScales,
        index: usize,
    ) -> Self {
        let name = scales.signals[index].name.clone();
        let place = nominal.definitions.iter().position(|known| known.name == name);
        let site = SiteRef::Signal(place.unwrap_or(index), name.clone());
        Self::new(effect, law, nominal, scales, site, Side::Dynamics).bind("u", Expr::name(name))
    }

    /// A force at a site; `v` and `x` are velocity and position, if the site has them.
    pub fn of_force(
        effect: &dyn Effect,
        law: &'static str,
        nominal: &'a Model,
        scales: &'a ReplayScales,
        index: usize,
    ) -> Self {
        let force = &scales.sites[index];
        let site = SiteRef::Force(index, force.name.clone());
        let mut sketch = Self::new(effect, law, nominal, scales, site, Side::Dynamics);
        sketch.force = Some(force);
        for (local, signal) in [("v", &force.velocity), ("x", &force.position)] {
            if let Some((expr, _)) = signal {
                sketch = sketch.bind(local, expr.clone());
            }
        }
        sketch
    }

    /// An effect of the sensor of an output; `y` is what it measures.
    pub fn of_output(
        effect: &dyn Effect,
        law: &'static str,
        nominal: &'a Model,
        scales: &'a ReplayScales,
        index: usize,
    ) -> Self {
        let name = nominal.outputs[index].name.clone();
        let site = SiteRef::Output(index, name.clone());
        let sketch = Self::new(effect, law, nominal, scales, site, Side::Output);
        let measured = sketch.patch.fresh_name(&format!("{name}_measured"));
        sketch.bind("y", Expr::name(measured))
    }

    /// An error of a parameter, `p`.
    pub fn of_parameter(
        effect: &dyn Effect,
        law: &'static str,
        nominal: &'a Model,
        scales: &'a ReplayScales,
        index: usize,
    ) -> Self {
        let name = nominal.parameters[index].name.clone();
        let site = SiteRef::Parameter(index, name.clone());
        Self::new(effect, law, nominal, scales, site, Side::Dynamics).bind("p", Expr::name(name))
    }

    /// An effect in a simulator outside, which `definition` keeps at rest; `p` is what it rests at.
    pub(crate) fn of_native(
        effect: &dyn Effect,
        law: &'static str,
        nominal: &'a Model,
        scales: &'a ReplayScales,
        site: SiteRef,
        definition: &str,
    ) -> Self {
        let side = match site {
            SiteRef::Input(..) => Side::Input,
            SiteRef::Output(..) => Side::Output,
            _ => Side::Dynamics,
        };
        Self::new(effect, law, nominal, scales, site, side).bind("p", Expr::name(definition))
    }

    fn new(
        effect: &dyn Effect,
        law: &'static str,
        nominal: &'a Model,
        scales: &'a ReplayScales,
        site: SiteRef,
        side: Side,
    ) -> Self {
        let mut patch = Patch::of(nominal);
        patch.pin_step(scales.step);
        Self {
            prefix: site.prefix(),
            candidate: Candidate {
                label: effect.label(),
                law,
                family: effect.family(),
                site,
                partner: None,
                side,
                kind: Kind::Simulation,
                model: nominal.clone(),
                parameters: Vec::new(),
                starts: Vec::new(),
                spectral: None,
                rounding: None,
            },
            patch,
            bound: Vec::new(),
            states: Vec::new(),
            memories: Vec::new(),
            force: None,
            problem: None,
        }
    }

    /// Gives up with this reason unless `condition` holds.
    #[must_use]
    pub fn require(mut self, condition: bool, reason: Reason) -> Self {
        if !condition {
            self.fail(reason);
        }
        self
    }

    /// Lets a local name stand for an expression of the model.
    #[must_use]
    pub fn bind(mut self, local: &str, value: impl Into<Expr>) -> Self {
        self.bound.push((local.to_owned(), value.into()));
        self
    }

    /// Takes up definitions that an expression of the scales needs, such as
    /// [`ForceScale::helpers`]. Those that the model has from another effect are not added again.
    #[must_use]
    pub fn with_helpers(mut self, helpers: &[Definition]) -> Self {
        for helper in helpers {
            if !self.candidate.model.definitions.contains(helper) {
                self.patch.add_definition(&helper.name, helper.value.clone());
            }
        }
        self
    }

    /// Lets a local name stand for a template.
    #[must_use]
    pub fn abbreviate(mut self, local: &str, template: &str) -> Self {
        let value = self.expr(template);
        self.bind(local, value)
    }

    /// Adds a strength: absent at 0. Bounds are in units of `scale`.
    #[must_use]
    pub fn strength(
        self,
        local: &str,
        name: &str,
        unit: impl Into<String>,
        scale: f64,
        bounds: [f64; 2],
    ) -> Self {
        self.parameter(local, name, unit.into(), scale, bounds, 0.0, true)
    }

    /// Adds a strength of which the inverse is a limit, which is infinite at zero strength.
    #[must_use]
    pub fn limit(
        mut self,
        local: &str,
        name: &str,
        unit: impl Into<String>,
        scale: f64,
        bounds: [f64; 2],
    ) -> Self {
        self = self.strength(local, name, unit, scale, bounds);
        if let Some(parameter) = self.candidate.parameters.last_mut() {
            parameter.is_reciprocal = true;
        }
        self
    }

    /// Adds a shape parameter, the effect being simplest at `neutral`. Bounds and neutral value are
    /// in units of `scale`.
    #[must_use]
    pub fn shape(
        self,
        local: &str,
        name: &str,
        unit: impl Into<String>,
        scale: f64,
        bounds: [f64; 2],
        neutral: f64,
    ) -> Self {
        self.parameter(local, name, unit.into(), scale, bounds, neutral, false)
    }

    #[expect(clippy::too_many_arguments, reason = "the two public forms of it have fewer")]
    fn parameter(
        mut self,
        local: &str,
        name: &str,
        unit: String,
        scale: f64,
        [low, high]: [f64; 2],
        neutral: f64,
        is_strength: bool,
    ) -> Self {
        let name = self.fresh(name);
        let mut parameter = Parameter::new(name.clone(), unit.clone(), neutral * scale);
        parameter.bounds = Some([low * scale, high * scale]);
        if scale.is_finite() {
            self.patch.add_parameter(parameter);
        } else {
            self.fail(Reason::Still("what gives the scale"));
        }
        self.candidate.parameters.push(EffectParameter {
            name: name.clone(),
            unit,
            scale,
            low: low * scale,
            high: high * scale,
            neutral: neutral * scale,
            is_strength,
            is_reciprocal: false,
            is_native: false,
            in_another_run: InAnotherRun::default(),
        });
        self.bind(local, Expr::name(name))
    }

    /// Adds a starting point, in units of the scales. One that is out of bounds is left out.
    #[must_use]
    pub fn start(mut self, point: &[f64]) -> Self {
        let parameters = &self.candidate.parameters;
        let point: Vec<f64> = point.iter().zip(parameters).map(|(x, p)| x * p.scale).collect();
        let is_inside = parameters.iter().zip(&point).all(|(p, x)| p.low <= *x && *x <= p.high);
        if is_inside && point.len() == parameters.len() {
            self.candidate.starts.push(point);
        }
        self
    }

    /// Adds several starting points.
    #[must_use]
    pub fn starts<const N: usize>(self, points: impl IntoIterator<Item = [f64; N]>) -> Self {
        points.into_iter().fold(self, |sketch, point| sketch.start(&point))
    }

    /// Puts the candidate together.
    ///
    /// # Errors
    ///
    /// Returns what is missing or went wrong first.
    pub fn finish(mut self) -> Result<Candidate, NotTestable> {
        if self.candidate.starts.is_empty() {
            self.fail(Reason::Bounds);
        }
        if self.problem.is_none() && self.candidate.kind == Kind::Simulation {
            for state in self.states {
                self.patch.add_state(state);
            }
            match self.patch.finish() {
                Ok(model) => self.candidate.model = model,
                Err(error) => self.problem = Some(error.into()),
            }
        }
        let Candidate { label, law, ref site, .. } = self.candidate;
        match self.problem {
            None => Ok(self.candidate),
            Some(reason) => {
                Err(NotTestable { label, law, site: site.clone(), reason: Box::new(reason) })
            }
        }
    }

    /// Beginning of the names of everything that is added.
    pub(crate) fn prefix(&self) -> &str {
        &self.prefix
    }

    fn fresh(&self, name: &str) -> String {
        self.patch.fresh_name(&format!("{}_{name}", self.prefix))
    }

    fn fail(&mut self, reason: Reason) {
        self.problem.get_or_insert(reason);
    }

    /// The template with local names replaced; the latest binding of a name counts.
    fn expr(&mut self, template: &str) -> Expr {
        match Expr::parse(template) {
            Ok(expr) => expr.substitute(&|name| {
                let bound = self.bound.iter().rev().find(|(local, _)| local == name)?;
                Some(bound.1.clone())
            }),
            Err(error) => {
                self.fail(Reason::Syntax { template: template.to_owned(), error });
                Expr::Number(0.0)
            }
        }
    }
}
