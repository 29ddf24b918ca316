//! Scheduled models at design time.

use std::borrow::Borrow;

use fd_core::{Scalar, stage::BiasModel};
use fd_model::Record;

use super::{Regions, ScheduledSimulator};
use crate::{
    arx::{ArxModel, held_inputs},
    error::IdentError,
};

/// One set of difference equations per region.
#[derive(Clone, Debug, PartialEq)]
pub struct ScheduledModel {
    regions: Regions,
    locals: Vec<ArxModel>,
    learned: Vec<bool>,
}

impl ScheduledModel {
    /// A model from its parts, all of the same orders and channels.
    ///
    /// # Errors
    ///
    /// Returns an error when there is not one local model per region, or they differ.
    pub fn new(regions: Regions, locals: Vec<ArxModel>) -> Result<Self, IdentError> {
        let (expected, found) = (regions.len(), locals.len());
        if expected != found {
            return Err(IdentError::ModelMismatch { what: "number of regions", expected, found });
        }
        let facts = |m: &ArxModel| [m.nu(), m.residual_len(), m.orders().parameters(m.nu())];
        let what = ["number of inputs", "number of residuals", "number of parameters"];
        for local in &locals {
            let pairs = facts(&locals[0]).into_iter().zip(facts(local));
            for (what, (expected, found)) in what.into_iter().zip(pairs) {
                if expected != found {
                    return Err(IdentError::ModelMismatch { what, expected, found });
                }
            }
        }
        if regions.input() >= locals[0].nu() {
            let (setting, expected) = ("scheduling input", "below the number of inputs");
            let found = regions.input() as f64;
            return Err(IdentError::Setting { setting, expected, found });
        }
        let learned = vec![true; locals.len()];
        Ok(Self { regions, locals, learned })
    }

    /// Learns each region with `fit` from the samples at which it is the nearest one. Regions
    /// that the data do not suffice for take the model of the nearest region that learned one.
    ///
    /// # Errors
    ///
    /// Returns the error of the first region when no region could learn, and any error that is
    /// not about too little or too silent data.
    pub fn learn<R: Borrow<Record>>(
        regions: Regions,
        records: &[R],
        mut fit: impl FnMut(&[Record]) -> Result<ArxModel, IdentError>,
    ) -> Result<Self, IdentError> {
        let (mut found, mut first_error) = (Vec::new(), None);
        for region in 0..regions.len() {
            let seen: Vec<Record> =
                records.iter().map(|record| regions.seen_from(region, record.borrow())).collect();
            match fit(&seen) {
                Ok(model) => found.push(Some(model)),
                Err(error @ (IdentError::TooFewRows { .. } | IdentError::RankDeficient { .. })) => {
                    first_error.get_or_insert(error);
                    found.push(None);
                }
                Err(error) => return Err(error),
            }
        }
        let learned: Vec<bool> = found.iter().map(Option::is_some).collect();
        let distance = |a: usize, b: usize| (regions.centres()[a] - regions.centres()[b]).abs();
        let nearest = |region: usize| {
            found
                .iter()
                .enumerate()
                .filter_map(|(other, model)| model.as_ref().map(|model| (other, model)))
                .min_by(|(a, _), (b, _)| distance(region, *a).total_cmp(&distance(region, *b)))
                .map(|(_, model)| model.clone())
        };
        let locals: Option<Vec<ArxModel>> = (0..regions.len()).map(nearest).collect();
        match (locals, first_error) {
            (Some(locals), _) => Ok(Self { learned, ..Self::new(regions, locals)? }),
            (None, Some(error)) => Err(error),
            (None, None) => Err(IdentError::NoRecords),
        }
    }

    /// The regions.
    #[must_use]
    pub fn regions(&self) -> &Regions {
        &self.regions
    }

    /// The equations of each region.
    #[must_use]
    pub fn locals(&self) -> &[ArxModel] {
        &self.locals
    }

    /// Which regions had data of their own.
    #[must_use]
    pub fn learned(&self) -> &[bool] {
        &self.learned
    }

    /// All parameters: residual channel by residual channel, in each region by region.
    #[must_use]
    pub fn theta(&self) -> Vec<f64> {
        (0..self.locals[0].residual_len())
            .flat_map(|channel| self.locals.iter().flat_map(move |local| local.channel(channel)))
            .copied()
            .collect()
    }

    /// Simulates the record from rest and its inputs alone; missing inputs are held.
    ///
    /// # Errors
    ///
    /// Returns an error when the record has other channels than the model.
    pub fn simulate_record(&self, record: &Record) -> Result<Vec<f64>, IdentError> {
        self.locals[0].check_channels(record)?;
        let inputs = held_inputs(record);
        let mut simulator = self.freeze::<f64>()?;
        let ny = self.locals[0].residual_len();
        let mut simulated = vec![0.0; record.len() * ny];
        let rows = simulated.chunks_exact_mut(ny).zip(inputs.chunks_exact(self.locals[0].nu()));
        rows.for_each(|(mu, u)| simulator.simulate(u, mu));
        Ok(simulated)
    }

    /// Moves the model to run time.
    ///
    /// # Errors
    ///
    /// Never fails for a model that was checked by [`ScheduledModel::new`].
    pub fn freeze<T: Scalar>(&self) -> Result<ScheduledSimulator<T>, IdentError> {
        let locals = self.locals.iter().map(ArxModel::freeze).collect::<Result<_, _>>()?;
        Ok(ScheduledSimulator::new(self.regions.freeze(), locals))
    }
}
