//! A scenario ready to run.

use fd_model::fault::{ChannelRef, Site};

use super::{
    config::CompareConfig,
    engines::EnginePlants,
    error::CompareError,
    fault::FaultKind,
    own::{OwnError, OwnPlants},
    plants::{Ask, Plants, Runs},
    scenario::Scenario,
};

/// A scenario ready to run.
pub(super) struct Scene<'a> {
    pub config: &'a CompareConfig,
    pub index: usize,
    pub kinds: Vec<FaultKind>,
    plants: Box<dyn Plants + 'a>,
}

impl<'a> Scene<'a> {
    pub(super) fn new(config: &'a CompareConfig, index: usize) -> Result<Self, CompareError> {
        let scenario: &Scenario = &config.scenarios[index];
        let plants: Box<dyn Plants + 'a> = match &scenario.own {
            None => Box::new(EnginePlants::new(config, scenario)?),
            Some(own) => {
                let scene = scenario.name.clone();
                let wrong = |error| CompareError::Own { scenario: scene, error: Box::new(error) };
                if scenario.present.is_some() {
                    return Err(wrong(OwnError::Present));
                }
                Box::new(OwnPlants::new(config, own).map_err(wrong)?)
            }
        };
        Ok(Self { config, index, kinds: plants.kinds().to_vec(), plants })
    }

    /// Index of the output whose sensor is faulty, if it is a sensor.
    pub(super) fn sensor(&self, kind: &FaultKind) -> Option<usize> {
        match &kind.site {
            Site::Sensor(ChannelRef::Index(index)) => Some(*index),
            Site::Sensor(ChannelRef::Name(name)) => self.outputs().iter().position(|o| o == name),
            _ => None,
        }
    }

    /// Names of the outputs.
    pub(super) fn outputs(&self) -> Vec<String> {
        self.plants.outputs()
    }

    /// All runs of one plant.
    pub(super) fn runs(&self, ask: Ask) -> Result<Runs, CompareError> {
        self.plants.runs(ask)
    }
}
