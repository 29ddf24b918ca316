//! The simulation of a patched model as a generator of a spec.

use std::collections::BTreeMap;

use fd_core::{IoDims, stage::ResidualGenerator};
use fd_model::{Discrete, Record, StateSpace};
use fd_nonlinear::patched::{PatchedDesign, Tracked, Tracking};
use fd_residual::{
    DesignError, GeneratorDesign, ResidualForm, simulation::SimulationDesign,
    weighted::FilteredDesign,
};
use fd_sim::model::Hold;

use super::{
    GeneratorSpec, error::GeneratorSpecError, filter::same_channels, model_source::ModelSource,
};
use crate::spec::NominalPlant;

/// What a spec says of a simulation with tracked parameters.
pub(super) struct PatchedSpec<'a> {
    pub model: &'a ModelSource,
    pub track: &'a BTreeMap<String, f64>,
    pub suspicion: f64,
    pub memory_s: f64,
    pub settle_s: f64,
}

/// A simulation with tracked parameters at design time. Its form is that of an open-loop simulation of the
/// linear model of the pipeline.
#[derive(Clone, Debug)]
pub(super) struct SimulatedDesign {
    design: PatchedDesign,
    linear: StateSpace<Discrete>,
}

impl PatchedSpec<'_> {
    /// The simulation, behind it the observer with a rate if there is one.
    pub(super) fn watched(
        &self,
        plant: &NominalPlant<'_>,
        healthy: &[Record],
        rate: Option<f64>,
    ) -> Result<Box<dyn GeneratorDesign>, GeneratorSpecError> {
        Ok(match rate {
            Some(rate) => Box::new(self.observed(plant, healthy, rate)?),
            None => Box::new(self.design(plant, healthy)?),
        })
    }

    /// The simulation, and behind it the observer of the linear model as it sees outputs: `H_y` of its form. Where the
    /// simulation is the linear model, that is the observer itself, as `H_u = −H_y G` for every observer.
    fn observed(
        &self,
        plant: &NominalPlant<'_>,
        healthy: &[Record],
        rate: f64,
    ) -> Result<FilteredDesign<SimulatedDesign>, GeneratorSpecError> {
        let observer = GeneratorSpec::Observer { rate }.linear(plant.system, healthy)?;
        let filter = observer.form()?.hy()?;
        Ok(FilteredDesign::new(self.design(plant, healthy)?, &filter)?)
    }

    /// The simulation, its parameters tracked as far as the healthy logs allow.
    fn design(
        &self,
        plant: &NominalPlant<'_>,
        healthy: &[Record],
    ) -> Result<SimulatedDesign, GeneratorSpecError> {
        let ts = plant.system.domain().ts;
        let nominal = self.model.read()?.nominal(ts)?;
        if nominal.model().hold != Hold::Zero {
            return Err(GeneratorSpecError::Hold);
        }
        let simulator =
            nominal.simulator(ts).map_err(|e| GeneratorSpecError::Nonlinear(e.into()))?;
        let log = healthy.first();
        let (system, scaling) = (plant.system, plant.scaling());
        same_channels("input", system.nu(), log.map(Record::inputs), simulator.inputs())?;
        same_channels("output", system.ny(), log.map(Record::outputs), simulator.outputs())?;
        let known: Vec<String> = simulator.parameters().iter().map(|p| p.name.clone()).collect();
        let step = ts.seconds().sqrt();
        let tracked = |(name, drift): (&String, &f64)| {
            let Some(parameter) = known.iter().position(|known| known == name) else {
                let known: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
                let (known, found) = (known.join(", "), name.clone());
                return Err(GeneratorSpecError::Unknown { table: "track", known, found });
            };
            Ok(Tracked { parameter, drift: drift * step })
        };
        let parameters = self.track.iter().map(tracked).collect::<Result<Vec<_>, _>>()?;
        let mut design = PatchedDesign::new(simulator, scaling)?;
        if !parameters.is_empty() {
            let memory = (self.memory_s / ts.seconds()).max(1.0);
            let tracking = Tracking { parameters, suspicion: self.suspicion, memory };
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative; what is beyond all samples leaves none"
            )]
            let settle = (self.settle_s / ts.seconds()).max(0.0) as usize;
            design = design.tracking(&tracking, healthy, settle)?;
        }
        Ok(SimulatedDesign { design, linear: system.clone() })
    }
}

impl GeneratorDesign for SimulatedDesign {
    fn io(&self) -> IoDims {
        self.design.io()
    }

    fn residual_len(&self) -> usize {
        self.design.io().ny
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        SimulationDesign::new(&self.linear)?.form()
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        Ok(Box::new(self.design.freeze()))
    }
}
