//! Linear models about a point, by central differences.

use faer::Mat;
use fd_model::{Channel, Continuous, StateSpace};

use super::{
    dynamics::Dynamics,
    jacobian::relative_jacobian,
    rhs::Engine17,
    state::{NX, NY, input_channels, output_channels, state_channels},
    trim::Trim,
};
use crate::{
    error::EngineError,
    model::{EngineModel, OperatingPoint},
};

/// Relative step of the fuel flow; rates are almost linear in it.
const FUEL_STEP: f64 = 1e-5;

/// Column of the input for relative deviations.
fn relative_input<const N: usize>(
    engine: &impl Dynamics<f64, N>,
    x: &[f64; N],
    fuel: f64,
) -> Mat<f64> {
    let step = FUEL_STEP * fuel;
    let (up, down) = (engine.rates(x, fuel + step).0, engine.rates(x, fuel - step).0);
    Mat::from_fn(N, 1, |i, _| (up[i] - down[i]) / (2.0 * step) * fuel / x[i])
}

/// The linear model of any engine about an equilibrium `x` at `fuel` (kg/s), in physical units.
///
/// # Errors
///
/// Returns an error when a derivative is not finite.
pub(super) fn linearise<const N: usize>(
    engine: &impl Dynamics<f64, N>,
    x: &[f64; N],
    fuel: f64,
    states: Vec<Channel>,
    name: String,
) -> Result<EngineModel, EngineError> {
    let a = relative_jacobian(engine, x, fuel);
    let b = relative_input(engine, x, fuel);
    let measured = engine.measured();
    let model = StateSpace::new(
        Mat::from_fn(N, N, |i, j| a[(i, j)] * x[i] / x[j]),
        Mat::from_fn(N, 1, |i, _| b[(i, 0)] * x[i] / fuel),
        Mat::from_fn(NY, N, |i, j| if measured[i] == j { 1.0 } else { 0.0 }),
        Mat::zeros(NY, 1),
        Continuous,
    )?;
    Ok(EngineModel {
        name,
        model,
        inputs: input_channels(),
        outputs: output_channels(),
        states,
        operating_point: Some(OperatingPoint {
            x: x.to_vec(),
            u: vec![fuel],
            y: measured.map(|i| x[i]).to_vec(),
        }),
        note: "engine17 by central differences; T_29 is our reading of the paper's output".into(),
    })
}

impl Engine17<f64> {
    /// The linear model about an equilibrium, in physical units; see [`EngineModel::per_unit`].
    ///
    /// # Errors
    ///
    /// Returns an error when a derivative is not finite.
    ///
    /// ```
    /// use fd_jetengine::engine17::{Engine17, Parameters};
    ///
    /// let engine = Engine17::new(&Parameters::default())?;
    /// let linear = engine.linearise(&engine.trim(0.712)?)?.per_unit()?;
    /// assert!(linear.model.is_stable()?);
    /// # Ok::<(), fd_jetengine::EngineError>(())
    /// ```
    pub fn linearise(&self, trim: &Trim) -> Result<EngineModel, EngineError> {
        let name = format!("engine17 at {} kg/s", trim.fuel);
        linearise::<NX>(self, &trim.x, trim.fuel, state_channels(), name)
    }
}
