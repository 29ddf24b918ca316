//! A linear model of state equations at a point, by central differences.

use faer::Mat;
use fd_model::{Discrete, SampleTime, StateSpace};

use crate::{error::NonlinearError, model::StateEquations};

/// Where state equations are linearised, and how large a change of each signal is ordinary there.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatingPoint {
    /// States.
    pub x: Vec<f64>,
    /// Inputs.
    pub u: Vec<f64>,
    /// Ordinary changes of the states, above zero, in their units.
    pub dx: Vec<f64>,
    /// Ordinary changes of the inputs, above zero, in their units.
    pub du: Vec<f64>,
}

/// Relative size of a step, near the cube root of the rounding unit.
const STEP: f64 = 6e-6;

/// `A = ∂f/∂x`, `B = ∂f/∂u`, `C = ∂h/∂x`, `D = ∂h/∂u` of one sample at a point, for samples `ts` apart: what the
/// linear methods of `fd-residual` can be designed for. The relative error is some `1e-10`.
///
/// ```
/// use fd_nonlinear::{OperatingPoint, linearise};
/// use fd_sim::{model::Model, simulate::StateMap};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "tank"
/// sample_time = 0.5
/// inputs = { q = { unit = "m^3/s" } }
/// states = { h = { unit = "m", initial = 1.0, derivative = "q - 0.2*sqrt(h)" } }
/// outputs = { level = { unit = "m", value = "h" } }
/// "#.parse()?;
/// let map = StateMap::new(&model, &[], model.sample_time()?)?;
/// let at = OperatingPoint { x: vec![1.0], u: vec![0.2], dx: vec![1.0], du: vec![1.0] };
/// let linear = linearise(&map, &at, model.sample_time()?)?;
/// // At rest the level forgets at half of 0.2/√1 per second.
/// assert!((linear.a()[(0, 0)] - (-0.5 * 0.1_f64).exp()).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when there is not one number per signal, or a slope is not finite.
pub fn linearise(
    equations: &dyn StateEquations,
    at: &OperatingPoint,
    ts: SampleTime,
) -> Result<StateSpace<Discrete>, NonlinearError> {
    let (nx, io) = (equations.nx(), equations.io());
    let lengths = [
        ("operating point of the states", nx, at.x.len()),
        ("operating point of the inputs", io.nu, at.u.len()),
        ("changes of the states", nx, at.dx.len()),
        ("changes of the inputs", io.nu, at.du.len()),
    ];
    for (what, expected, found) in lengths {
        if expected != found {
            return Err(NonlinearError::Length { what, expected, found });
        }
    }
    let mut equations = equations.boxed();
    let changes: Vec<f64> = at.dx.iter().chain(&at.du).copied().collect();
    let values: Vec<f64> = at.x.iter().chain(&at.u).copied().collect();
    let mut slopes = Mat::<f64>::zeros(nx + io.ny, nx + io.nu);
    for (j, (value, change)) in values.iter().zip(&changes).enumerate() {
        let step = STEP * value.abs().max(change.abs());
        let mut end = |sign: f64| {
            let mut asked = values.clone();
            asked[j] += sign * step;
            let (x, u) = asked.split_at(nx);
            let mut answer = vec![0.0; nx + io.ny];
            let (next, y) = answer.split_at_mut(nx);
            // Not the first sample of a run, at which a model may behave in its own way.
            equations.advance(1, x, u, u, next);
            equations.output(1, x, u, y);
            answer
        };
        let (up, down) = (end(1.0), end(-1.0));
        for i in 0..nx + io.ny {
            slopes[(i, j)] = (up[i] - down[i]) / (2.0 * step);
        }
    }
    if !slopes.norm_max().is_finite() {
        return Err(NonlinearError::NotFinite { what: "slope" });
    }
    let part = |row: usize, column: usize, rows: usize, columns: usize| {
        slopes.submatrix(row, column, rows, columns).to_owned()
    };
    let (a, b) = (part(0, 0, nx, nx), part(0, nx, nx, io.nu));
    let (c, d) = (part(nx, 0, io.ny, nx), part(nx, nx, io.ny, io.nu));
    Ok(StateSpace::new(a, b, c, d, Discrete { ts })?)
}
