//! Effects that a simulator outside of this program has in itself.
//!
//! Such an effect rests in the simulator, at a neutral value of one of its parameters; as a candidate that parameter
//! is moved. One with the label of an effect of the library, at the same place, is another law of the same cause: with
//! the same name, unit and starts where that has a single strength. So viscous friction at a joint and the damping
//! of that joint are one answer, and whichever law explains the log better is its law.
//!
//! *When not to use:* for a parameter whose value is uncertain anyway. That is a parameter with a tolerance.

use fd_sim::{
    model::Model,
    scales::ReplayScales,
    simulate::{NativeEffect, Nominal, Shell},
};

use super::{
    Candidate, Effect, Offers, Sketch, candidate::EffectParameter, label::interned, library,
    site::SiteRef,
};

/// The law of an effect that the simulator has in itself.
pub const NATIVE: &str = "native";

/// Where fits of a limit start, in parts of its size: what it limits is not known.
const LIMITS: [f64; 7] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];
/// How far an effect may go that states no bounds, in parts of its size.
const FAR: f64 = 100.0;

/// The effects that the simulator of a shell has in itself, as candidates of a diagnosis.
///
/// ```
/// use fd_model::Channel;
/// use fd_sim::{
///     model::{Model, Parameter},
///     simulate::{EquationSimulator, Shell},
/// };
///
/// // One that says of no effect that it has it.
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = { u = { unit = "1" } }
/// states = { x = { unit = "1", initial = 0.0, derivative = "u - x" } }
/// outputs = { y = { unit = "1", value = "x" } }
/// "#.parse()?;
/// let shell = Shell::new("lag", Box::new(EquationSimulator::<f64>::new(&model)?))?;
/// assert!(fd_effect::natives(&shell).is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn natives(shell: &Shell) -> Vec<Box<dyn Effect>> {
    let each = shell.natives().enumerate();
    each.map(|(i, (definition, native))| {
        let effect = Native::new(definition, native, site(shell, i, native));
        Box::new(effect) as Box<dyn Effect>
    })
    .collect()
}

/// Where a native effect is: at a port, input or output of that name, else at a part of the simulator.
fn site(shell: &Shell, i: usize, native: &NativeEffect) -> SiteRef {
    let (inside, model, place) = (shell.inside(), shell.model(), native.place.as_str());
    let port = inside.ports().iter().position(|port| port.channel.name == place);
    let input = inside.inputs().iter().position(|input| input.name == place);
    let output = inside.outputs().iter().position(|output| output.name == place);
    // The model has them in the same order, by names that can stand in an expression.
    let port = port.and_then(|i| Some(SiteRef::Force(i, model.sites.get(i)?.name.clone())));
    let input = input.and_then(|i| Some(SiteRef::Input(i, model.inputs.get(i)?.name.clone())));
    let output = output.and_then(|i| Some(SiteRef::Output(i, model.outputs.get(i)?.name.clone())));
    port.or(input).or(output).unwrap_or_else(|| SiteRef::Part(i, place.to_owned()))
}

/// One of them.
#[derive(Debug)]
struct Native {
    label: &'static str,
    family: &'static str,
    /// The library's effect of this label.
    known: Option<Box<dyn Effect>>,
    definition: String,
    site: SiteRef,
    effect: NativeEffect,
}

impl Native {
    fn new(definition: &str, effect: &NativeEffect, site: SiteRef) -> Self {
        let known = library().into_iter().find(|known| known.label() == effect.label);
        let family = match (&known, effect.family.as_str()) {
            (Some(known), _) => known.family(),
            (None, "") => interned(&effect.label),
            (None, family) => interned(family),
        };
        let label = interned(&effect.label);
        Self {
            label,
            family,
            known,
            definition: definition.to_owned(),
            site,
            effect: effect.clone(),
        }
    }

    /// The single strength that the library's effect of this label has at this place.
    fn twin(&self, nominal: &Model, scales: &ReplayScales) -> Option<EffectParameter> {
        let offers = self.known.as_ref()?.candidates(nominal, scales);
        let is_it = |candidate: &Candidate| {
            candidate.site == self.site
                && candidate.parameters.len() == 1
                && candidate.parameters.iter().all(|p| p.is_strength && !p.is_reciprocal)
        };
        let twin = offers.into_iter().flatten().find(is_it)?;
        twin.parameters.into_iter().next()
    }

    /// How far it may move, from where it rests.
    fn reach(&self) -> [f64; 2] {
        let NativeEffect { parameter, size, .. } = &self.effect;
        let free = [parameter.value - FAR * size, parameter.value + FAR * size];
        parameter.bounds.unwrap_or(free).map(|end| end - parameter.value)
    }
}

impl Effect for Native {
    fn label(&self) -> &'static str {
        self.label
    }

    fn family(&self) -> &'static str {
        self.family
    }

    fn is_signed(&self) -> bool {
        self.reach()[0] < 0.0
    }

    /// What it does at first is for the simulator to know.
    fn has_slope(&self) -> bool {
        false
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let NativeEffect { parameter, size, is_reciprocal, .. } = &self.effect;
        let sketch =
            Sketch::of_native(self, NATIVE, nominal, scales, self.site.clone(), &self.definition);
        let [low, high] = self.reach();
        let is_stated = parameter.bounds.is_some();
        let sketch = match self.twin(nominal, scales).filter(|_| !is_reciprocal) {
            Some(twin) => {
                let (scale, prefix) = (twin.scale, format!("{}_", sketch.prefix()));
                let name = twin.name.strip_prefix(&prefix).unwrap_or(&twin.name).to_owned();
                // Where the simulator has some of it already, there may be less.
                let least = twin.low.min(-twin.high);
                // What the simulator states has the last word. The library's range comes from the replay, and a
                // nominal simulator that turns over and over has no idea of the spring that would hold it.
                let range =
                    if is_stated { [low, high] } else { [low.max(least), high.min(twin.high)] };
                let [low, high] = range.map(|end| end / scale);
                let mut starts = vec![[0.05], [0.4], [-0.05], [-0.3]];
                let beyond = [0.2, 1.0].map(|share| share * size / scale);
                let is_new = |start: &f64| twin.high / scale < *start && *start < high;
                starts.extend(beyond.into_iter().filter(is_new).map(|start| [start]));
                sketch.strength("c", &name, twin.unit, scale, [low, high]).starts(starts)
            }
            None if *is_reciprocal => {
                let bounds = [low.max(0.0) / size, high / size];
                // Not as the simulator calls it, which need be no name of an expression.
                let sketch = sketch.limit("c", "limit", &parameter.unit, *size, bounds);
                sketch.starts(LIMITS.map(|s| [s]))
            }
            None => {
                let bounds = [low / size, high / size];
                let sketch = sketch.strength("c", "change", &parameter.unit, *size, bounds);
                // The first that is within the bounds: it is a slope that is looked for.
                sketch.starts([[1.0], [-1.0], [0.2], [-0.2]])
            }
        };
        let mut candidate = sketch.wrap_native("p + c").finish();
        if let Ok(candidate) = &mut candidate {
            candidate.parameters.iter_mut().for_each(|parameter| parameter.is_native = true);
        }
        vec![candidate]
    }
}
