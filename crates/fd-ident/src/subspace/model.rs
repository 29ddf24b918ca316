//! Bias models in state-space form at design time.

use faer::Mat;
use fd_core::{Shape, ShapeError, stage::BiasModel};
use fd_model::{Discrete, Record, StateSpace, riccati};

use crate::{arx::held_inputs, error::IdentError};

/// A state-space model of the bias in all residual channels, with a constant in each.
#[derive(Clone, Debug)]
pub struct StateSpaceBias {
    system: StateSpace<Discrete>,
    offset: Vec<f64>,
    /// Gain by which an observed bias corrects the state.
    gain: Mat<f64>,
}

impl StateSpaceBias {
    /// A model with a gain by which [`BiasModel::observe`] finds the state: that of the Kalman
    /// filter that trusts model and measurement alike, with noise on the states of the same total
    /// variance, seen through `C`, as the measurement noise `noise` on the channels.
    ///
    /// # Errors
    ///
    /// Returns an error when there is not one constant and one variance per channel, or no such
    /// filter exists.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_ident::subspace::StateSpaceBias;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let bias = StateSpaceBias::new(lag, vec![0.0], &[1e-4])?;
    /// assert!(bias.gain()[(0, 0)] > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        system: StateSpace<Discrete>,
        offset: Vec<f64>,
        noise: &[f64],
    ) -> Result<Self, IdentError> {
        let (nx, ny) = (system.nx(), system.ny());
        for (role, found) in [("constants", offset.len()), ("noise variances", noise.len())] {
            if found != ny {
                let (expected, found) = (Shape::new(ny, 1), Shape::new(found, 1));
                return Err(ShapeError { role, expected, found }.into());
            }
        }
        let gain = if nx == 0 {
            Mat::zeros(0, ny)
        } else {
            let c = system.c();
            let largest = noise.iter().fold(0.0, |m: f64, v| m.max(*v));
            // Without any noise every ratio is the same.
            let scale = if largest > 0.0 { largest } else { 1.0 };
            let r =
                Mat::from_fn(ny, ny, |i, j| if i == j { noise[i].max(1e-12 * scale) } else { 0.0 });
            let total: f64 = (0..ny).map(|i| r[(i, i)]).sum();
            let seen = c.squared_norm_l2();
            let share = if seen > 0.0 { total / seen } else { total };
            let q = Mat::from_fn(nx, nx, |i, j| if i == j { share } else { 0.0 });
            let filter = riccati::discrete_filter(system.a(), c, q.as_ref(), r.as_ref())?;
            filter.gain
        };
        Ok(Self { system, offset, gain })
    }

    /// The linear model.
    #[must_use]
    pub fn system(&self) -> &StateSpace<Discrete> {
        &self.system
    }

    /// Constant of each residual channel.
    #[must_use]
    pub fn offset(&self) -> &[f64] {
        &self.offset
    }

    /// Gain by which an observed bias corrects the state.
    #[must_use]
    pub fn gain(&self) -> &Mat<f64> {
        &self.gain
    }

    /// `A`, `B`, `C`, `D` row by row and the constants, for reports.
    #[must_use]
    pub fn parameters(&self) -> Vec<f64> {
        let matrices = [self.system.a(), self.system.b(), self.system.c(), self.system.d()];
        matrices
            .into_iter()
            .flat_map(|m| (0..m.nrows()).flat_map(move |i| (0..m.ncols()).map(move |j| m[(i, j)])))
            .chain(self.offset.iter().copied())
            .collect()
    }

    /// Simulates the record from rest and its inputs alone; missing inputs are held.
    ///
    /// # Errors
    ///
    /// Returns an error when the record has other channels than the model.
    pub fn simulate_record(&self, record: &Record) -> Result<Vec<f64>, IdentError> {
        let pairs = [
            ("number of inputs", self.system.nu(), record.inputs().len()),
            ("number of residuals", self.system.ny(), record.outputs().len()),
        ];
        for (what, expected, found) in pairs {
            if expected != found {
                return Err(IdentError::ModelMismatch { what, expected, found });
            }
        }
        let (nu, ny) = (self.system.nu(), self.system.ny());
        let inputs = held_inputs(record);
        let mut simulator = self.freeze::<f64>()?;
        let mut simulated = vec![0.0; record.len() * ny];
        for (k, mu) in simulated.chunks_exact_mut(ny).enumerate() {
            simulator.simulate(&inputs[k * nu..(k + 1) * nu], mu);
        }
        Ok(simulated)
    }
}
