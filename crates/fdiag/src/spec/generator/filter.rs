//! Nonlinear filters as generators of a spec.

use faer::Mat;
use fd_core::{IoDims, stage::ResidualGenerator};
use fd_model::{Channel, Discrete, Record, StateSpace, riccati};
use fd_nonlinear::{
    Noise, NoisyModel, OperatingPoint, ScaledEquations, extended::ExtendedDesign, linearise,
    particle::ParticleDesign, unscented::UnscentedDesign,
};
use fd_residual::{DesignError, GeneratorDesign, ResidualForm, observer::ObserverDesign};

use super::{
    deviations::{DeviationSpec, Sized},
    error::GeneratorSpecError,
    model_source::{ModelSource, NamedEquations},
};
use crate::spec::NominalPlant;

/// What all filters of a spec have in common.
pub(super) struct FilterSpec<'a> {
    pub model: &'a ModelSource,
    pub process_noise: &'a DeviationSpec,
    pub output_noise: Option<&'a DeviationSpec>,
    pub initial: Option<&'a DeviationSpec>,
}

/// Which filter.
#[derive(Clone, Debug)]
enum Filter {
    Extended(ExtendedDesign),
    Unscented(UnscentedDesign),
    Particle(ParticleDesign),
}

/// A nonlinear filter at design time. Its form is that of the Kalman filter of the model linearised where
/// the filter starts; what runs departs from it as the plant departs from there.
#[derive(Clone, Debug)]
pub(super) struct FilterDesign {
    filter: Filter,
    linear: StateSpace<Discrete>,
}

impl FilterSpec<'_> {
    /// The extended Kalman filter.
    pub(super) fn extended(
        &self,
        plant: &NominalPlant<'_>,
        healthy: &[Record],
        linearised_over: u32,
    ) -> Result<FilterDesign, GeneratorSpecError> {
        let (model, linear) = self.model(plant, healthy)?;
        let design = ExtendedDesign::new(model).linearised_over(linearised_over as usize);
        Ok(FilterDesign { filter: Filter::Extended(design), linear })
    }

    /// The unscented Kalman filter.
    pub(super) fn unscented(
        &self,
        plant: &NominalPlant<'_>,
        healthy: &[Record],
        kappa: Option<f64>,
    ) -> Result<FilterDesign, GeneratorSpecError> {
        let (model, linear) = self.model(plant, healthy)?;
        Ok(FilterDesign { filter: Filter::Unscented(UnscentedDesign::new(model, kappa)?), linear })
    }

    /// The bootstrap particle filter.
    pub(super) fn particle(
        &self,
        plant: &NominalPlant<'_>,
        healthy: &[Record],
        (particles, seed): (usize, u64),
    ) -> Result<FilterDesign, GeneratorSpecError> {
        let (model, linear) = self.model(plant, healthy)?;
        let design = ParticleDesign::new(model, particles, seed)?;
        Ok(FilterDesign { filter: Filter::Particle(design), linear })
    }

    /// The model with its noises in the signals of the pipeline, and linearised where it starts.
    fn model(
        &self,
        plant: &NominalPlant<'_>,
        healthy: &[Record],
    ) -> Result<(NoisyModel, StateSpace<Discrete>), GeneratorSpecError> {
        let ts = plant.system.domain().ts;
        let named = self.model.read()?.equations(ts)?;
        check_channels(&named, plant, healthy)?;
        let NamedEquations { equations, states, outputs, noise, .. } = named;
        let start: Vec<f64> = states.iter().map(|state| state.value).collect();
        let sized = |usual: fn(Option<f64>) -> Option<f64>| -> Vec<Sized<'_>> {
            let one = |state: &'_ fd_sim::simulate::Initial| (state.value, usual(state.tolerance));
            let all = states.iter().map(|state| (&state.channel.name, one(state)));
            all.map(|(name, (size, usual))| Sized { name, size, usual }).collect()
        };
        // A state of which nothing is said is not driven by noise, and known as well as the file says.
        let drive =
            DeviationSpec::of(Some(self.process_noise), "process_noise", &sized(|_| Some(0.0)))?;
        let initial =
            DeviationSpec::of(self.initial, "initial", &sized(|known| known.or(Some(0.0))))?;
        let scaling = plant.scaling();
        let scaled = ScaledEquations::new(equations, scaling.clone())?;
        let rest = initial_inputs(plant, healthy);
        let readings = readings(&scaled, &start, &rest, &scaling);
        let of_outputs: Vec<Sized<'_>> = (outputs.iter().zip(noise).zip(&readings))
            .map(|((channel, usual), size)| Sized { name: &channel.name, size: *size, usual })
            .collect();
        let output = DeviationSpec::of(self.output_noise, "output_noise", &of_outputs)?;
        let noise = Noise {
            process: drive.iter().map(|drive| drive * ts.seconds().sqrt()).collect(),
            output: output
                .iter()
                .zip(&scaling.outputs)
                .map(|(deviation, scale)| deviation / scale.scale.unwrap_or(1.0).abs())
                .collect(),
            initial,
        };
        let or_one = |size: f64| if size > 0.0 { size } else { 1.0 };
        let changes = noise.initial.iter().zip(&noise.process).zip(&start);
        let at = OperatingPoint {
            dx: changes.map(|((a, b), x)| or_one(a.max(*b).max(x.abs()))).collect(),
            du: vec![1.0; rest.len()],
            x: start.clone(),
            u: rest,
        };
        let linear = linearise(&scaled, &at, ts)?;
        Ok((NoisyModel::new(scaled, start, noise)?, linear))
    }
}

/// The first complete inputs of the healthy logs; where a filter is linearised.
fn initial_inputs(plant: &NominalPlant<'_>, healthy: &[Record]) -> Vec<f64> {
    let known = healthy.iter().find_map(|log| {
        (0..log.len()).map(|k| log.u(k)).find(|u| u.iter().all(|value| value.is_finite()))
    });
    known.map_or_else(|| vec![0.0; plant.system.nu()], <[f64]>::to_vec)
}

/// What the sensors say at the start, in units.
fn readings(
    equations: &ScaledEquations,
    x: &[f64],
    u: &[f64],
    scaling: &fd_model::Scaling,
) -> Vec<f64> {
    use fd_nonlinear::StateEquations;
    let mut y = vec![0.0; equations.io().ny];
    equations.clone().output(0, x, u, &mut y);
    y.iter().zip(&scaling.outputs).map(|(y, scale)| scale.physical(*y)).collect()
}

/// Whether the model has the channels of the pipeline; by name where a log says the names.
fn check_channels(
    named: &NamedEquations,
    plant: &NominalPlant<'_>,
    healthy: &[Record],
) -> Result<(), GeneratorSpecError> {
    let system = plant.system;
    let log = healthy.first();
    same_channels("input", system.nu(), log.map(Record::inputs), &named.inputs)?;
    same_channels("output", system.ny(), log.map(Record::outputs), &named.outputs)
}

/// Whether there are as many channels as expected, with the names of a log.
pub(super) fn same_channels(
    signal: &'static str,
    count: usize,
    log: Option<&[Channel]>,
    found: &[Channel],
) -> Result<(), GeneratorSpecError> {
    let is_same = match log {
        Some(log) => log.iter().map(|c| &c.name).eq(found.iter().map(|c| &c.name)),
        None => found.len() == count,
    };
    if is_same {
        return Ok(());
    }
    let names = |channels: &[Channel]| {
        let names: Vec<String> = channels.iter().map(|c| format!("`{}`", c.name)).collect();
        names.join(", ")
    };
    let expected = log.map_or_else(|| format!("of the model, {count} in number"), names);
    Err(GeneratorSpecError::Channels { signal, expected, found: names(found) })
}

impl FilterDesign {
    fn model(&self) -> &NoisyModel {
        match &self.filter {
            Filter::Extended(design) => design.model(),
            Filter::Unscented(design) => design.model(),
            Filter::Particle(design) => design.model(),
        }
    }
}

impl GeneratorDesign for FilterDesign {
    fn io(&self) -> IoDims {
        self.model().io()
    }

    fn residual_len(&self) -> usize {
        self.model().io().ny
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        let noise = self.model().noise();
        let square = |deviations: &[f64]| {
            let n = deviations.len();
            Mat::from_fn(n, n, |i, j| if i == j { deviations[i].powi(2) } else { 0.0 })
        };
        let (q, r) = (square(&noise.process), square(&noise.output));
        let (a, c) = (self.linear.a(), self.linear.c());
        let filter = riccati::discrete_filter(a, c, q.as_ref(), r.as_ref())?;
        ObserverDesign::with_gain(&self.linear, filter.gain.as_ref())?.form()
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        Ok(match &self.filter {
            Filter::Extended(design) => Box::new(design.freeze()),
            Filter::Unscented(design) => Box::new(design.freeze()),
            Filter::Particle(design) => Box::new(design.freeze()),
        })
    }
}
