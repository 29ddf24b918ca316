//! The 3-state jet engine of Chen, Patton and Zhang (1996), linear and with its quadratic term.

use fd_core::{IoDims, stage::Plant};
use fd_model::{Channel, Continuous, SampleTime, StateSpace};
use fd_numeric::dot;

use super::matrix;
use crate::{error::EngineError, model::EngineModel, runge_kutta};

const NX: usize = 3;
const NY: usize = 6;
const PRODUCTS: usize = 6;

const A: [[f64; NX]; NX] =
    [[-1.5581, 0.6925, 0.3974], [0.2619, -2.2228, 0.2238], [0.0, 0.0, -10.0]];

const B: [[f64; 1]; NX] = [[0.0], [0.0], [10.0]];

#[allow(clippy::unreadable_literal, reason = "transcribed as printed")]
const C: [[f64; NX]; NY] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.55107, 0.1332, 0.30603],
    [0.55217, 0.13526, 0.32912],
    [-0.25693, -0.23625, 0.61299],
];

/// Coefficients of `d(x) = [x₁² x₂² x₃² x₁x₂ x₁x₃ x₂x₃]`.
const E: [[f64; PRODUCTS]; NX] = [
    [1.3293, 3.444, 0.1375, -5.1304, -1.7826, -1.8719],
    [5.6812, -0.5281, -0.3385, -1.6193, 0.5229, 0.0],
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
];

/// The linear model of the jet engine of J. Chen, R. J. Patton and H. Y. Zhang, "Design of
/// unknown input observers and robust fault detection filters", Int. J. Control 63(1), 1996.
///
/// States: speeds of both shafts and fuel flow behind the actuator; input: fuel command; all
/// relative deviations from an equilibrium (printed as a speed of 450 rpm) already.
///
/// # Errors
///
/// Never in practice; the signature is that of every model.
///
/// ```
/// let engine = fd_jetengine::chen_patton_zhang()?;
/// assert_eq!((engine.model.nx(), engine.model.ny()), (3, 6));
/// assert!(engine.model.is_stable()?);
/// # Ok::<(), fd_jetengine::EngineError>(())
/// ```
pub fn chen_patton_zhang() -> Result<EngineModel, EngineError> {
    let channels = |names: &[&str]| -> Vec<Channel> {
        names.iter().map(|&name| Channel::new(name, "1")).collect()
    };
    let d = [[0.0; 1]; NY];
    Ok(EngineModel {
        name: "Chen-Patton-Zhang".into(),
        model: StateSpace::new(matrix(&A), matrix(&B), matrix(&C), matrix(&d), Continuous)?,
        inputs: channels(&["Wf command"]),
        outputs: channels(&["n_L", "n_H", "W_f", "p_2", "p_4", "t_4"]),
        states: channels(&["n_L", "n_H", "W_f"]),
        operating_point: None,
        note: "Chen, Patton & Zhang 1996; relative deviations as published".into(),
    })
}

/// The same engine with the quadratic term `E* d(x)` that the paper gives as the unknown input,
/// sampled with a zero-order hold (classical Runge-Kutta, steps of at most 10 ms).
///
/// Writes NaN once the quadratic term has run away.
///
/// ```
/// use fd_core::stage::Plant;
/// use fd_jetengine::ChenPattonZhang;
/// use fd_model::SampleTime;
///
/// let plant = ChenPattonZhang::new(SampleTime::new(0.05)?);
/// let mut next = [0.0; 3];
/// plant.advance(&[0.0; 3], &[0.2], &mut next);
/// assert!(0.0 < next[2] && next[2] < 0.2);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ChenPattonZhang {
    step: f64,
    substeps: u32,
}

impl ChenPattonZhang {
    /// Longest internal step, s; the pole at -10 1/s would bear 0.278 s.
    const MAX_STEP: f64 = 0.01;

    /// The engine at a sample time.
    #[must_use]
    pub fn new(ts: SampleTime) -> Self {
        let (substeps, step) = runge_kutta::substeps(ts, Self::MAX_STEP);
        Self { step, substeps }
    }

    fn rates(x: &[f64; NX], u: f64) -> [f64; NX] {
        let [n_l, n_h, fuel] = *x;
        let products = [n_l * n_l, n_h * n_h, fuel * fuel, n_l * n_h, n_l * fuel, n_h * fuel];
        std::array::from_fn(|i| dot(&A[i], x) + B[i][0] * u + dot(&E[i], &products))
    }
}

impl Plant<f64> for ChenPattonZhang {
    fn nx(&self) -> usize {
        NX
    }

    fn io(&self) -> IoDims {
        IoDims { nu: 1, ny: NY }
    }

    fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
        let mut state = [x[0], x[1], x[2]];
        for _ in 0..self.substeps {
            let k1 = Self::rates(&state, u[0]);
            state = runge_kutta::step(&state, &k1, self.step, |x| Self::rates(x, u[0]));
        }
        let finite = state.iter().all(|v| v.is_finite());
        x_next.copy_from_slice(&if finite { state } else { [f64::NAN; NX] });
    }

    fn output(&self, x: &[f64], _u: &[f64], y: &mut [f64]) {
        for (y, row) in y.iter_mut().zip(&C) {
            *y = row.iter().zip(x).map(|(c, x)| c * x).sum();
        }
    }
}
