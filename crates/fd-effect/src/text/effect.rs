//! An effect as text, as an effect.

use fd_sim::{model::Model, scales::ReplayScales};

use super::{On, TextEffect, parameter::TextParameter};
use crate::{Effect, Offers, Reason, Sketch};

/// The one law that it has.
const LAW: &str = "text";
/// Most starts; the first of each parameter come first.
const STARTS: usize = 64;

impl Effect for TextEffect {
    fn label(&self) -> &'static str {
        self.label
    }

    fn family(&self) -> &'static str {
        self.family
    }

    fn is_signed(&self) -> bool {
        let mut strengths = self.parameters.iter().filter(|(_, p)| p.is_strength());
        strengths.any(|(_, parameter)| parameter.range()[0] < 0.0)
    }

    /// Nobody knows.
    fn has_slope(&self) -> bool {
        false
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let is_meant = |name: &str| self.at.is_empty() || self.at.iter().any(|at| at == name);
        let names: Vec<&str> = match self.on {
            On::Input => scales.inputs.iter().map(|input| input.name.as_str()).collect(),
            On::Force => scales.sites.iter().map(|site| site.name.as_str()).collect(),
            On::Output => nominal.outputs.iter().map(|output| output.name.as_str()).collect(),
            On::Parameter => nominal.parameters.iter().map(|p| p.name.as_str()).collect(),
        };
        let places = names.iter().enumerate().filter(|(_, name)| is_meant(name));
        places.map(|(i, _)| self.at_place(nominal, scales, i).finish()).collect()
    }
}

impl TextEffect {
    fn at_place<'a>(&self, nominal: &'a Model, scales: &'a ReplayScales, i: usize) -> Sketch<'a> {
        let mut sketch = match self.on {
            On::Input => Sketch::of_input(self, LAW, nominal, scales, i),
            On::Force => self.of_force(nominal, scales, i),
            On::Output => Sketch::of_output(self, LAW, nominal, scales, i),
            On::Parameter => Sketch::of_parameter(self, LAW, nominal, scales, i),
        };
        for (name, parameter) in &self.parameters {
            let (unit, size) = (parameter.unit.as_str(), parameter.size);
            let bounds = parameter.range().map(|end| end / size);
            sketch = match parameter.shape {
                None => sketch.strength(name, name, unit, size, bounds),
                Some(value) => sketch.shape(name, name, unit, size, bounds, value / size),
            };
        }
        for (name, state, _) in &self.states {
            sketch = sketch.dynamic(name, name, &state.unit);
        }
        for (name, _, rate) in &self.states {
            sketch = sketch.moves(name, &rate.to_string());
        }
        let law = self.law.to_string();
        sketch = match self.on {
            On::Input => sketch.wrap_input(&law),
            On::Force => sketch.force(self.label.replace('-', "_").as_str(), &law),
            On::Output => sketch.wrap_output(&law),
            On::Parameter => sketch.wrap_parameter(&law),
        };
        self.starts().iter().fold(sketch, |sketch, start| sketch.start(start))
    }

    /// A force needs what it depends on.
    fn of_force<'a>(&self, nominal: &'a Model, scales: &'a ReplayScales, i: usize) -> Sketch<'a> {
        let laws = || self.states.iter().map(|(_, _, rate)| rate).chain([&self.law]);
        let needs = |name: &str| laws().any(|law| law.mentions(name));
        let site = &scales.sites[i];
        Sketch::of_force(self, LAW, nominal, scales, i)
            .require(!needs("v") || site.velocity.is_some(), Reason::Missing("velocity"))
            .require(!needs("x") || site.position.is_some(), Reason::Missing("position"))
    }

    /// All combinations of the starts of the parameters, in parts of their sizes.
    fn starts(&self) -> Vec<Vec<f64>> {
        let mut all = vec![Vec::new()];
        for (_, parameter) in &self.parameters {
            let values = starts(parameter);
            let with = |start: &Vec<f64>| -> Vec<Vec<f64>> {
                values.iter().map(|value| [&start[..], &[*value]].concat()).collect()
            };
            all = all.iter().flat_map(with).take(STARTS).collect();
        }
        all
    }
}

/// Where fits of a parameter start, in parts of its size.
fn starts(parameter: &TextParameter) -> Vec<f64> {
    let [low, high] = parameter.range().map(|end| end / parameter.size);
    let own = parameter.starts.iter().map(|start| start / parameter.size);
    let usual: &[f64] = if parameter.is_strength() { &[1.0, -1.0] } else { &[] };
    let shape = parameter.shape.map(|value| value / parameter.size);
    let all = own.chain(shape).chain(usual.iter().copied());
    let within: Vec<f64> = all.filter(|start| low <= *start && *start <= high).collect();
    // A strength may be bounded below its size.
    if within.is_empty() { vec![0.5 * (low + high)] } else { within }
}
