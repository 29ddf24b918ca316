//! Random engines of the same type: perturbation of the physical parameters.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::params::Parameters;
use crate::error::EngineError;

impl Parameters {
    /// Another engine of the type: each volume, duct, inertia and map exponent multiplied by a
    /// factor of its own, uniform in `1 ± fraction`.
    ///
    /// The reference point stays an equilibrium, so steady states near it hardly move, while
    /// dynamics and slopes do: unlike independent changes of matrix entries, this keeps the
    /// structure of the model. Scatter of efficiencies and flow capacities is a matter of
    /// [`Health`](super::Health). The same seed gives the same engine.
    ///
    /// # Errors
    ///
    /// Returns an error unless `0 ≤ fraction ≤ 0.3`.
    ///
    /// ```
    /// use fd_jetengine::engine17::{Engine17, Parameters};
    ///
    /// let twin = Parameters::default().scattered(0.1, 7)?;
    /// assert!((twin.inertia_l / 5.5 - 1.0).abs() <= 0.1);
    /// let engine = Engine17::new(&twin)?;
    /// assert!(engine.linearise(&engine.trim(0.712)?)?.model.is_stable()?);
    /// # Ok::<(), fd_jetengine::EngineError>(())
    /// ```
    pub fn scattered(&self, fraction: f64, seed: u64) -> Result<Self, EngineError> {
        let (low, high) = (0.0, 0.3);
        if !(low..=high).contains(&fraction) {
            let quantity = "relative scatter of the parameters";
            return Err(EngineError::OutOfRange {
                quantity,
                value: fraction,
                low,
                high,
                unit: "1",
            });
        }
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut scattered = self.clone();
        for parameter in scattered.physical_mut() {
            *parameter *= 1.0 + fraction * rng.random_range(-1.0..=1.0);
        }
        Ok(scattered)
    }

    /// Parameters that shape dynamics and slopes without moving the reference point.
    fn physical_mut(&mut self) -> [&mut f64; 25] {
        let Self { volumes: v, ducts: d, lpc, hpc, hpt, lpt, .. } = self;
        [
            &mut self.inertia_l,
            &mut self.inertia_h,
            &mut v.hpc_inlet,
            &mut v.combustor,
            &mut v.inter_turbine,
            &mut v.turbine_exit,
            &mut v.bypass,
            &mut v.jet_pipe,
            &mut d.core,
            &mut d.bypass_in,
            &mut d.turbine_exit,
            &mut d.bypass_out,
            &mut lpc.flow_exponent,
            &mut lpc.flow_curvature,
            &mut lpc.pressure_exponent,
            &mut lpc.cubic_height,
            &mut lpc.efficiency_speed,
            &mut lpc.efficiency_flow,
            &mut hpc.flow_exponent,
            &mut hpc.flow_curvature,
            &mut hpc.pressure_exponent,
            &mut hpc.efficiency_speed,
            &mut hpc.efficiency_loading,
            &mut hpt.efficiency_curvature,
            &mut lpt.efficiency_curvature,
        ]
    }
}
