//! The nominal plant as a diagnosis takes it.

use fd_model::{ChannelScale, Discrete, Scaling, StateSpace};

/// A discrete linear model, and what its signals are in units.
///
/// Linear generators need the model alone, and `&StateSpace` will do wherever one of these is taken.
/// Nonlinear ones know the units of their own model and have to be told what a signal of the pipeline is
/// worth.
///
/// ```
/// use faer::mat;
/// use fdiag::{
///     model::{ChannelScale, Discrete, SampleTime, Scaling, StateSpace},
///     spec::NominalPlant,
/// };
///
/// let domain = Discrete { ts: SampleTime::new(0.1)? };
/// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
/// let plain = NominalPlant::from(&lag);
/// assert_eq!(plain.scaling().outputs, [ChannelScale::default()]);
/// let scales = vec![ChannelScale::per_unit(300.0, 10.0)];
/// let scaled = plain.in_units(Scaling { inputs: scales.clone(), outputs: scales });
/// assert_eq!(scaled.scaling().outputs[0].physical(1.0), 310.0);
/// # Ok::<(), fdiag::model::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct NominalPlant<'a> {
    /// The linear model.
    pub system: &'a StateSpace<Discrete>,
    scaling: Option<Scaling>,
}

impl<'a> From<&'a StateSpace<Discrete>> for NominalPlant<'a> {
    fn from(system: &'a StateSpace<Discrete>) -> Self {
        Self { system, scaling: None }
    }
}

impl NominalPlant<'_> {
    /// The same plant with signals that are deviations from an operating point in units of a scale.
    #[must_use]
    pub fn in_units(self, scaling: Scaling) -> Self {
        Self { scaling: Some(scaling), ..self }
    }

    /// Operating points and scales; without any, signals are in their units.
    #[must_use]
    pub fn scaling(&self) -> Scaling {
        let plain = |channels: usize| vec![ChannelScale::default(); channels];
        self.scaling.clone().unwrap_or_else(|| Scaling {
            inputs: plain(self.system.nu()),
            outputs: plain(self.system.ny()),
        })
    }
}
