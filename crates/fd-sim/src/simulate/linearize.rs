//! Linear models of a model at an operating point, through exact derivatives.

use faer::Mat;
use fd_model::{Continuous, Discrete, SampleTime, StateSpace, TimeDomain};

use super::{
    error::SimulateError,
    flat::{FIRST_STATE, Flat, flatten},
    jacobian::jacobian,
};
use crate::{
    equation::Expr,
    model::{Delay, Law, Model},
};

/// Where a model is linearised.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatingPoint {
    /// Parameters.
    pub theta: Vec<f64>,
    /// States of plant and controller.
    pub x: Vec<f64>,
    /// External inputs.
    pub u: Vec<f64>,
    /// Time, in seconds.
    pub t: f64,
}

impl OperatingPoint {
    /// Nominal parameters, nominal initial state, zero inputs, time zero.
    #[must_use]
    pub fn initial(model: &Model) -> Self {
        Self {
            theta: model.nominal(),
            x: model.initial(),
            u: vec![0.0; model.external_inputs().len()],
            t: 0.0,
        }
    }
}

/// Linearises a continuous model: `A = ∂f/∂x`, `B = ∂f/∂u`, `C = ∂h/∂x`, `D = ∂h/∂u` in the order
/// of states, external inputs and outputs. The loop of a continuous controller is closed.
///
/// ```
/// use fd_sim::{model::Model, simulate::{OperatingPoint, linearize}};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "pendulum"
/// sample_time = 0.01
/// inputs = { u = { unit = "1/s^2" } }
/// outputs = { y = { unit = "rad", value = "q" } }
/// [states]
/// q = { unit = "rad", initial = 0.0, derivative = "w" }
/// w = { unit = "rad/s", initial = 0.0, derivative = "u - 4*sin(q)" }
/// "#.parse()?;
/// let linear = linearize(&model, &OperatingPoint::initial(&model))?;
/// assert_eq!(linear.a()[(1, 0)], -4.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when a state has an update law, the controller is sampled, there is a delay, the
/// point has the wrong sizes, or a derivative is not finite there.
pub fn linearize(
    model: &Model,
    at: &OperatingPoint,
) -> Result<StateSpace<Continuous>, SimulateError> {
    if model.controller.as_ref().is_some_and(|controller| controller.sample_time.is_some()) {
        return Err(SimulateError::SampledController);
    }
    require(
        model,
        |law| matches!(law, Law::Derivative(_)),
        "linearisation in continuous time",
        "derivatives only",
    )?;
    state_space(model, at, &flatten(model, &[]), Continuous, model.sample_time)
}

/// Linearises a model of which every state has an update law, as [`linearize`] does.
///
/// # Errors
///
/// Returns an error when a state has a derivative, the controller is sampled, the point has the
/// wrong sizes, or a derivative is not finite there.
pub fn linearize_discrete(
    model: &Model,
    at: &OperatingPoint,
) -> Result<StateSpace<Discrete>, SimulateError> {
    if model.controller.is_some() {
        return Err(SimulateError::SampledController);
    }
    require(
        model,
        |law| matches!(law, Law::Update(_)),
        "linearisation in discrete time",
        "updates only",
    )?;
    let ts = SampleTime::new(model.sample_time)?;
    state_space(model, at, &flatten(model, &[]), Discrete { ts }, ts.seconds())
}

fn require(
    model: &Model,
    fits: impl Fn(&Law) -> bool,
    operation: &'static str,
    needed: &'static str,
) -> Result<(), SimulateError> {
    match model.all_states().find(|state| !fits(&state.law)) {
        Some(state) => Err(SimulateError::Kind { operation, needed, state: state.name.clone() }),
        None => Ok(()),
    }
}

fn state_space<D: TimeDomain>(
    model: &Model,
    at: &OperatingPoint,
    flat: &Flat,
    domain: D,
    dt: f64,
) -> Result<StateSpace<D>, SimulateError> {
    let lengths = [
        ("parameters", model.parameters.len(), at.theta.len()),
        ("states", flat.states, at.x.len()),
        ("external inputs", flat.inputs, at.u.len()),
    ];
    for (what, expected, found) in lengths {
        if expected != found {
            return Err(SimulateError::Length { what, expected, found });
        }
    }
    let values = |name: &str| {
        model.parameters.iter().position(|known| known.name == name).map(|i| at.theta[i])
    };
    let is_late = |delay: &&Delay| delay.time.evaluate(&values).is_ok_and(|time: f64| 0.0 < time);
    if let Some(delay) = model.delays.iter().find(is_late) {
        return Err(SimulateError::Delay { delay: delay.name.clone() });
    }
    let laws = model.all_states().map(|state| state.law.expr().clone());
    let functions: Vec<Expr> = laws.chain(flat.outputs.iter().cloned()).collect();
    let (nx, nu, ny) = (flat.states, flat.inputs, flat.outputs.len());
    let slopes = evaluate(flat, &functions, nx + nu, at, dt)?;
    let part = |row: usize, col: usize, rows: usize, cols: usize| {
        Mat::from_fn(rows, cols, |i, j| slopes[(row + i) * (nx + nu) + col + j])
    };
    let (a, b) = (part(0, 0, nx, nx), part(0, nx, nx, nu));
    let (c, d) = (part(nx, 0, ny, nx), part(nx, nx, ny, nu));
    Ok(StateSpace::new(a, b, c, d, domain)?)
}

/// Slopes of `functions` with respect to the first `variables` of states and inputs, row by row.
pub(super) fn evaluate(
    flat: &Flat,
    functions: &[Expr],
    variables: usize,
    at: &OperatingPoint,
    dt: f64,
) -> Result<Vec<f64>, SimulateError> {
    let program =
        jacobian(&flat.scope, functions, &flat.scope.fast[FIRST_STATE..FIRST_STATE + variables])?;
    let mut workspace = program.workspace::<f64>();
    let values = |to: &mut [f64], from: &mut dyn Iterator<Item = f64>| {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = from);
    };
    values(workspace.slow_mut(), &mut at.theta.iter().copied().chain([dt]));
    program.prepare(&mut workspace);
    // Held signals of a sampled controller and delayed values stay zero.
    let fast = [at.t, 0.0].into_iter().chain(at.x.iter().copied()).chain(at.u.iter().copied());
    values(workspace.fast_mut(), &mut fast.into_iter());
    let mut slopes = vec![0.0; program.results()];
    program.run(&mut workspace, &mut slopes);
    Ok(slopes)
}
