//! Many pipelines at once: a fleet of units of one type, or the runs of a Monte Carlo study.
//!
//! All units share one residual generator, one structure of the bias model and one kind of
//! detector and rule; each learns a bias of its own and is judged by itself. What a
//! [`Pipeline`](crate::core::Pipeline) does for one unit sample by sample, a [`Fleet`] does for
//! [`Fleet::PART`] units side by side:
//!
//! | stage | how |
//! |---|---|
//! | `r = H_u u + H_y y` | one product of matrices per sample: the generator's times the states and samples of all units |
//! | learning `θ` | [`BatchRls`](crate::ident::batch::BatchRls) in SIMD lanes |
//! | `r* = r − μ̂` by simulation | row by row over all units |
//! | detector and rule | those of the pipeline, unit by unit |
//!
//! A part stays in the cache for a whole [`FleetBlock`] of samples, and parts are spread over the
//! cores. The answers depend neither on the number of cores nor on how samples are divided into
//! blocks.
//!
//! # Training
//!
//! Each unit learns from [`FleetDesign::training`] samples, then its `θ*` is frozen for good. That
//! is the [`ResidualCompensator`](crate::compensate::residual_compensation::ResidualCompensator)
//! without its tests of convergence, its trial, its watch for hard faults and for the trained
//! range.
//!
//! # When not to use it
//!
//! For one unit, or when each sample must be answered at once: use a pipeline. When training must
//! end by itself, or has to notice that something is wrong: use pipelines. For nonlinear residual
//! generators.

mod bias;
mod block;
mod design;
mod error;
mod part;
mod unit;

use fd_core::{
    StateVisitor,
    stage::{DecisionRule, Detector, Stage},
};
use rayon::prelude::*;

pub use self::{
    block::FleetBlock,
    design::{FleetDesign, FleetScalar},
    error::FleetError,
    unit::UnitStatus,
};
use self::{block::PART, design::Shared, part::Part};

/// Running diagnoses of many units.
///
/// # Examples
///
/// 200 tanks whose outflow the model has too small, with noise; each learns its own bias from 300
/// samples. Then tank 7 gets a leak.
///
/// ```
/// use faer::mat;
/// use fdiag::{
///     compensate::{decide::{Debounce, Debouncing}, detect::Magnitude},
///     core::IoDims,
///     fleet::{Fleet, FleetBlock, FleetDesign},
///     ident::{arx::ArxOrders, rls::RlsDesign},
///     model::{Discrete, SampleTime, StateSpace},
///     residual::ResidualForm,
/// };
///
/// // r = y − 0.9 x̂, x̂ = y(k−1) + u(k−1) / 0.9: a parity equation of order one.
/// let domain = Discrete { ts: SampleTime::new(1.0)? };
/// let parity = StateSpace::new(
///     mat![[0.0]], mat![[1.0, 0.9]], mat![[-1.0]], mat![[0.0, 1.0]], domain,
/// )?;
/// let design = FleetDesign {
///     generator: ResidualForm::new(IoDims { nu: 1, ny: 1 }, parity)?,
///     orders: ArxOrders::new(1, 2, 0),
///     learning: RlsDesign::default(),
///     settling: 5,
///     training: 300,
///     detector: Magnitude::new(&[1.0], 0.05)?,
///     rule: Debounce::new(1, Debouncing::consecutive(3))?,
/// };
/// let mut fleet = Fleet::<f64, _, _>::new(&design, 200)?;
/// let mut block = FleetBlock::new(IoDims { nu: 1, ny: 1 }, 200, 500);
/// for tank in 0..200 {
///     let mut level = 0.0;
///     for k in 0..500 {
///         let inflow = f64::from(u32::from((k * 7919 / 31 + tank) % 5 > 2));
///         let noise = 0.001 * f64::from((k * 37 + tank * 11) % 17).sin();
///         let leak = if tank == 7 && k >= 400 { 0.2 } else { 0.0 };
///         block.set(tank as usize, k as usize, &[inflow], &[level + noise]);
///         level = 0.85 * level + inflow - leak;
///     }
/// }
/// fleet.update_on_all_cores(&block)?;
/// let alarmed: Vec<usize> = (0..200).filter(|&i| fleet.unit(i).decision.is_fault()).collect();
/// assert_eq!(alarmed, [7]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Fleet<T: FleetScalar, D, J> {
    shared: Shared<T>,
    units: usize,
    parts: Vec<Part<T, D, J>>,
}

impl<T, D, J> Fleet<T, D, J>
where
    T: FleetScalar,
    D: Detector<T> + Clone,
    J: DecisionRule<T> + Clone,
{
    /// Units that are computed side by side and fit a core's cache together.
    pub const PART: usize = PART;

    /// So many units of the same design, all at rest.
    ///
    /// # Errors
    ///
    /// Returns an error when the generator is unstable, its channels do not fit detector and rule,
    /// or the batch engine cannot learn with this design.
    pub fn new(design: &FleetDesign<D, J>, units: usize) -> Result<Self, FleetError> {
        let shared = Shared::new(design)?;
        let part = |first| Part::new(design, &shared, PART.min(units - first));
        let parts = (0..units).step_by(PART).map(part).collect::<Result<_, _>>()?;
        Ok(Self { shared, units, parts })
    }

    /// Number of units.
    #[must_use]
    pub fn len(&self) -> usize {
        self.units
    }

    /// Whether there are no units.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.units == 0
    }

    /// Takes all units through a block of samples, on this core, without allocating.
    ///
    /// # Errors
    ///
    /// Returns an error when the block was made for other channels or another number of units.
    pub fn update(&mut self, block: &FleetBlock<T>) -> Result<(), FleetError> {
        self.check(block)?;
        for (part, samples) in self.parts.iter_mut().zip(block.parts()) {
            part.update(&self.shared, samples)?;
        }
        Ok(())
    }

    /// The same on all cores of the present thread pool; the answers do not depend on it.
    ///
    /// # Errors
    ///
    /// As [`Self::update`].
    pub fn update_on_all_cores(&mut self, block: &FleetBlock<T>) -> Result<(), FleetError> {
        self.check(block)?;
        let shared = &self.shared;
        self.parts
            .par_iter_mut()
            .zip(block.parts().collect::<Vec<_>>())
            .try_for_each(|(part, samples)| part.update(shared, samples))
    }

    fn check(&self, block: &FleetBlock<T>) -> Result<(), FleetError> {
        let io = block.io();
        let compare = |what, expected, found| {
            if expected == found {
                Ok(())
            } else {
                Err(FleetError::Block { what, expected, found })
            }
        };
        compare("inputs", self.shared.io.nu, io.nu)?;
        compare("outputs", self.shared.io.ny, io.ny)?;
        compare("units", self.units, block.units())
    }

    /// How one unit is after its last sample.
    ///
    /// # Panics
    ///
    /// Panics when there is no such unit.
    #[must_use]
    pub fn unit(&self, unit: usize) -> UnitStatus<T> {
        self.parts[unit / PART].status(unit % PART)
    }

    /// Writes the bias parameters of one unit, those of residual channel 0 first: the frozen ones, or
    /// what has been learned so far.
    ///
    /// # Panics
    ///
    /// Panics when there is no such unit.
    pub fn theta_into(&self, unit: usize, theta: &mut [T]) {
        self.parts[unit / PART].theta_into(unit % PART, theta);
    }

    /// Writes the compensated residual of the last sample of one unit: `r − μ̂`, or `r` itself in
    /// training.
    ///
    /// # Panics
    ///
    /// Panics when there is no such unit.
    pub fn compensated_into(&self, unit: usize, r_star: &mut [T]) {
        self.parts[unit / PART].compensated_into(unit % PART, r_star);
    }
}

impl<T, D, J> Stage<T> for Fleet<T, D, J>
where
    T: FleetScalar,
    D: Detector<T> + Clone,
    J: DecisionRule<T> + Clone,
{
    fn reset(&mut self) {
        self.parts.iter_mut().for_each(Part::reset);
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        for part in &mut self.parts {
            part.visit_state(visitor);
        }
    }
}
