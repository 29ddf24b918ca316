//! What is true of a case: all that is needed to make its logs again.

use fd_sim::model::Model;
use serde::{Deserialize, Serialize};

use super::{
    conditions::Conditions,
    error::BlindError,
    excitation::{Drive, Shape},
    kind::CaseKind,
    laws::{Law, Origin, Place, Setting, catalogue},
    plants::{Plant, plant},
    random::{Random, named_seed},
    recorder::Recorder,
    rival::Oracle,
    scales::Scales,
    simulate::{Bench, Injected, Trace, Trial},
};

/// An effect that was put in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Label, as in the library of the diagnosis where that has it.
    pub label: String,
    /// Our law.
    pub law: String,
    /// Mechanism.
    pub family: String,
    /// Where the law comes from.
    pub origin: Origin,
    /// What it acts on.
    pub place: Place,
    /// Name of the input, site, parameter or output.
    pub site: String,
    /// Its place among those of the model.
    pub index: usize,
    /// The other end of a coupling.
    pub partner: Option<String>,
    /// Its place.
    pub partner_index: usize,
    /// Dimensionless strength.
    pub strength: f64,
    /// Draws for shapes.
    pub shape: [f64; 3],
    /// Seed of what is random in the effect.
    pub seed: u64,
    /// Squares of the noise that it leaves to a linearised refit of the nuisances.
    pub distance: f64,
}

/// What is true of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Name of the case.
    pub case: String,
    /// Kind.
    pub kind: CaseKind,
    /// Name of the plant.
    pub plant: String,
    /// Shape of the excitation.
    pub excitation: Shape,
    /// Samples of each run.
    pub samples: usize,
    /// Whether the noise is an AR(1) sequence with coefficient 0.8 instead of white.
    pub coloured: bool,
    /// Real noise over what the model states.
    pub noise_factor: f64,
    /// Seed of excitations, initial states and noise.
    pub seed: u64,
    /// Real parameters.
    pub parameters: Vec<f64>,
    /// The effects.
    pub effects: Vec<Effect>,
    /// Under which conditions the logs were taken.
    #[serde(default, skip_serializing_if = "Conditions::is_plain")]
    pub conditions: Conditions,
    /// What a perfect fit could and could not tell.
    pub oracle: Option<Oracle>,
}

/// Coefficient of coloured noise.
const COLOUR: f64 = 0.8;
/// Frequencies of a reference over those of the excitation of an input.
const REFERENCE: f64 = 0.5;

impl Truth {
    /// Coefficient of the AR(1) sequence that the noise is; 0 when it is white.
    pub(super) fn colour(&self) -> f64 {
        if self.coloured { COLOUR } else { 0.0 }
    }
}

/// A truth with its plant, ready to run.
pub(super) struct Scene<'a> {
    pub truth: &'a Truth,
    pub plant: &'static Plant,
    pub model: &'a Model,
    pub bench: Bench<'a>,
    pub scales: Scales,
    laws: Vec<Law>,
}

impl<'a> Scene<'a> {
    pub(super) fn new(truth: &'a Truth, model: &'a Model) -> Result<Self, BlindError> {
        let plant = plant(&truth.plant).ok_or_else(|| {
            BlindError::content(truth.case.as_ref(), format!("no plant `{}`", truth.plant))
        })?;
        let bench = Bench::new(plant, model)?;
        let mut recorder = Recorder::default();
        let (x0, u) = (initial(truth, model, 0), excitation(truth, plant, model, 0));
        let controller = truth.conditions.controller.as_ref().map(|controller| (controller, 0));
        let parameters = &truth.parameters;
        let trial = Trial { parameters, x0: &x0, u: &u, noise: None, controller };
        bench.run(&trial, Vec::new(), Some(&mut recorder))?;
        let scales = recorder.scales(model.sample_time);
        Ok(Self { truth, plant, model, bench, scales, laws: catalogue() })
    }

    /// The law of an effect at work, for a run.
    pub(super) fn inject(&self, effect: &Effect, run: u64) -> Option<Injected> {
        let law = self.laws.iter().find(|law| {
            law.label == effect.label && law.name == effect.law && law.place == effect.place
        })?;
        let setting = Setting {
            strength: effect.strength,
            shape: effect.shape,
            index: effect.index,
            partner: effect.partner_index,
            scales: &self.scales,
            seed: named_seed(effect.seed, &format!("run/{run}")),
        };
        let (index, partner) = (effect.index, effect.partner_index);
        Some(Injected { index, partner, mechanism: law.at(&setting) })
    }

    /// External inputs of a run, row by row.
    pub(super) fn excitation(&self, run: u64) -> Vec<f64> {
        excitation(self.truth, self.plant, self.model, run)
    }

    /// Real initial states of a run: uniform within their tolerances.
    pub(super) fn initial(&self, run: u64) -> Vec<f64> {
        initial(self.truth, self.model, run)
    }

    /// Noise of a run, row by row.
    fn noise(&self, run: u64) -> Vec<f64> {
        let random = &mut Random::named(self.truth.seed, &format!("noise/{run}"));
        let (truth, outputs) = (self.truth, &self.model.outputs);
        let k = truth.colour();
        let mut state: Vec<f64> = outputs.iter().map(|_| random.normal()).collect();
        let rows = rows(truth);
        let mut all = Vec::with_capacity(rows * outputs.len());
        for _ in 0..rows {
            for (state, output) in state.iter_mut().zip(outputs) {
                *state = k * *state + (1.0 - k * k).sqrt() * random.normal();
                all.push(truth.noise_factor * output.noise.unwrap_or(0.0) * *state);
            }
        }
        all
    }

    /// Outputs of a run with these effects; `None` when it diverges.
    pub(super) fn outputs(
        &self,
        effects: &[Effect],
        parameters: &[f64],
        x0: &[f64],
        run: u64,
        is_noisy: bool,
    ) -> Result<Option<Vec<f64>>, BlindError> {
        Ok(self.trace(effects, parameters, x0, run, is_noisy)?.map(|trace| trace.y))
    }

    /// A run with these effects; `None` when it diverges.
    pub(super) fn trace(
        &self,
        effects: &[Effect],
        parameters: &[f64],
        x0: &[f64],
        run: u64,
        is_noisy: bool,
    ) -> Result<Option<Trace>, BlindError> {
        let u = self.excitation(run);
        let noise = is_noisy.then(|| self.noise(run));
        let controller = self.truth.conditions.controller.as_ref().map(|c| (c, run));
        let trial = Trial { parameters, x0, u: &u, noise: noise.as_deref(), controller };
        let injected = effects.iter().filter_map(|effect| self.inject(effect, run)).collect();
        self.bench.run(&trial, injected, None)
    }
}

/// Rows of a run: what is logged, what was before, what goes on, and what is lost at the ends.
pub(super) fn rows(truth: &Truth) -> usize {
    let conditions = &truth.conditions;
    let parts = if conditions.is_cut { 2 } else { 1 };
    let margin = conditions.misreading.as_ref().map_or(0, super::misreading::Misreading::margin);
    (conditions.before + parts * truth.samples + 2 * margin) * conditions.stretch()
}

fn initial(truth: &Truth, model: &Model, run: u64) -> Vec<f64> {
    let random = &mut Random::named(truth.seed, &format!("initial/{run}"));
    let states = model.states.iter();
    states.map(|s| s.initial + s.tolerance.unwrap_or(0.0) * random.uniform(-1.0, 1.0)).collect()
}

fn excitation(truth: &Truth, plant: &Plant, model: &Model, run: u64) -> Vec<f64> {
    let stretch = truth.conditions.stretch();
    let samples = rows(truth) / stretch;
    let signals: Vec<Vec<f64>> = plant
        .drives
        .iter()
        .enumerate()
        .map(|(i, drive)| {
            let seed = named_seed(truth.seed, &format!("excitation/{run}/{i}"));
            // What drives the plant under an unknown controller is the reference of that.
            let reference = truth.conditions.controller.as_ref().filter(|c| c.input == i);
            let drive = reference.map_or(*drive, |controller| {
                let [centre, amplitude] = controller.reference;
                // An output follows slower than an input can change.
                Drive { centre, amplitude, band: drive.band.map(|f| REFERENCE * f) }
            });
            drive.signal(truth.excitation, samples, model.sample_time, seed)
        })
        .collect();
    let row = |k: usize| signals.iter().map(move |signal| signal[k / stretch]);
    (0..rows(truth)).flat_map(row).collect()
}
