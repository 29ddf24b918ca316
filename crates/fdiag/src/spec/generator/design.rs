//! From a line of a spec to the generator: the kinds that have a nonlinear model, those that learn one, the linear ones.

use fd_model::Record;
use fd_residual::{GeneratorDesign, weighted::WeightedDesign};

use super::{
    GeneratorSpec, data, error::GeneratorSpecError, filter::FilterSpec, parameter::dense,
    tracked::PatchedSpec,
};
use crate::spec::NominalPlant;

impl GeneratorSpec {
    /// Designs the generator for `model`, followed by the weighting if there is one.
    ///
    /// `healthy` holds the logs of the healthy plant that a learned disturbance is learned from,
    /// in the units of the model; other kinds do not look at them.
    ///
    /// # Errors
    ///
    /// Returns why no such generator exists for this model.
    ///
    /// ```
    /// use faer::mat;
    /// use fdiag::{model::{Discrete, SampleTime, StateSpace}, spec::GeneratorSpec};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let model = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let design = GeneratorSpec::Observer { rate: 2.0 }.design(&model, None, &[])?;
    /// assert_eq!(design.residual_len(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn design<'a>(
        &self,
        model: impl Into<NominalPlant<'a>>,
        weighting: Option<&[Vec<f64>]>,
        healthy: &[Record],
    ) -> Result<Box<dyn GeneratorDesign>, GeneratorSpecError> {
        let plant = model.into();
        let special = self.nonlinear(&plant, healthy);
        let design = match special.or_else(|| data::design(self, &plant, healthy)) {
            Some(design) => design?,
            None => self.linear(plant.system, healthy)?,
        };
        let Some(rows) = weighting else { return Ok(design) };
        Ok(Box::new(WeightedDesign::new(design, dense(rows).as_ref())?))
    }

    /// The generators that have a nonlinear model of their own.
    fn nonlinear(
        &self,
        plant: &NominalPlant<'_>,
        healthy: &[Record],
    ) -> Option<Result<Box<dyn GeneratorDesign>, GeneratorSpecError>> {
        if let Self::Patched { model, track, suspicion, memory_s, settle_s, observer_rate } = self {
            let (suspicion, memory_s, settle_s) = (*suspicion, *memory_s, *settle_s);
            let spec = PatchedSpec { model, track, suspicion, memory_s, settle_s };
            return Some(spec.watched(plant, healthy, *observer_rate));
        }
        let (Self::Extended { model, process_noise, output_noise, initial, .. }
        | Self::Unscented { model, process_noise, output_noise, initial, .. }
        | Self::Particle { model, process_noise, output_noise, initial, .. }) = self
        else {
            return None;
        };
        let (output_noise, initial) = (output_noise.as_ref(), initial.as_ref());
        let filter = FilterSpec { model, process_noise, output_noise, initial };
        let design = match self {
            Self::Unscented { kappa, .. } => filter.unscented(plant, healthy, *kappa),
            Self::Particle { particles, seed, .. } => {
                filter.particle(plant, healthy, (*particles, *seed))
            }
            Self::Extended { linearised_over: n, .. } => filter.extended(plant, healthy, *n),
            _ => return None,
        };
        Some(design.map(|design| Box::new(design) as Box<dyn GeneratorDesign>))
    }
}
