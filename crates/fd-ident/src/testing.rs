//! Every identifier and every bias model, for tests that must see them all.
//!
//! Only with the feature `testing`. A test of a law walks these lists and keeps none of its own, so
//! what is added to a list is put to every law.

use std::error::Error;

use faer::Mat;
use fd_core::{
    Scalar,
    stage::{BiasModel, Identifier},
    testing::Named,
};
use fd_model::{Channel, Discrete, Record, SampleTime, StateSpace};

use crate::{
    arx::{ArxModel, ArxOrders, ArxSimulator, RecursiveArx},
    extended::RecursiveArmax,
    hammerstein::{Basis, Expanded, Expansion},
    instrumental::{IvDesign, RecursiveIv},
    random_walk::{Drift, KalmanRls, RandomWalkDesign},
    rls::{
        ConventionalRls, Falling, Forgetting, QrRls, RlsDesign, RlsKernel, UdRls, WindowDesign,
        WindowRls,
    },
    scheduled::{RecursiveScheduled, Regions, ScheduledModel},
    subspace::StateSpaceBias,
};

/// Identifiers with their names.
pub type Identifiers<T> = Vec<Named<dyn Identifier<T>>>;

/// Bias models with their names.
pub type BiasModels<T> = Vec<Named<dyn BiasModel<T>>>;

/// Every identifier of this crate, and difference equations with every kernel and every kind of
/// forgetting, for `nu` inputs within ±1 and `residual_len` residual channels.
///
/// # Errors
///
/// Returns an error when the orders leave no parameters, or there are no inputs.
pub fn every_identifier<T: Scalar>(
    orders: ArxOrders,
    nu: usize,
    residual_len: usize,
) -> Result<Identifiers<T>, Box<dyn Error>> {
    let n = orders.checked_parameters(nu)?;
    // Little enough prior variance for single precision.
    let design =
        |forgetting| RlsDesign { prior_variance: 1e2, ..RlsDesign::forgetting(forgetting) };
    let plain = design(Forgetting::None);
    let lambda = 0.95;
    let falling = Some(Falling { ratio: 0.95, least: 0.1 });
    let mut all: Identifiers<T> = Vec::new();
    for (name, forgetting) in [
        ("arx", Forgetting::None),
        ("arx, equation 18", Forgetting::Equation18 { alpha: 0.5, falling: None }),
        ("arx, equation 18 with a falling alpha", Forgetting::Equation18 { alpha: 1.0, falling }),
        ("arx, exponential", Forgetting::Exponential { lambda }),
        ("arx, directional", Forgetting::Directional { lambda }),
        ("arx, bounded", Forgetting::Bounded { lambda, variance: 10.0 }),
        ("arx, resetting", Forgetting::Resetting { lambda, floor: 0.01 }),
    ] {
        let kernel = UdRls::<T>::new(n, &design(forgetting))?;
        all.push((name, Box::new(RecursiveArx::new(orders, nu, residual_len, kernel)?)));
    }
    let window = WindowDesign { samples: 20, prior_variance: 1e2 };
    let drift = Drift::Uniform { variance: 1e-3 };
    let walk = RandomWalkDesign { prior_variance: 1e2, drift, ..RandomWalkDesign::default() };
    let regions = Regions::new(0, 5.0, vec![-0.1, 0.1])?;
    let curves = curves(nu)?;
    let width = curves.expanded_len();
    let wide = UdRls::<T>::new(orders.checked_parameters(width)?, &plain)?;
    let inner = RecursiveArx::new(orders, width, residual_len, wide)?;
    let iv = IvDesign { prior_variance: 1e2, warm_up: 20, ..IvDesign::default() };
    let noisy = UdRls::<T>::new(n + 2, &plain)?;
    let local = UdRls::<T>::new(n, &plain)?;
    all.extend([
        ("arx, covariance", arx(orders, nu, residual_len, ConventionalRls::<T>::new(n, &plain)?)?),
        ("arx, square root", arx(orders, nu, residual_len, QrRls::<T>::new(n, &plain)?)?),
        ("arx, window", arx(orders, nu, residual_len, WindowRls::<T>::new(n, &window)?)?),
        ("arx, random walk", arx(orders, nu, residual_len, KalmanRls::<T>::new(n, &walk)?)?),
        ("armax", Box::new(RecursiveArmax::new(orders, 2, nu, residual_len, noisy)?) as _),
        ("instrumental", Box::new(RecursiveIv::new(orders, nu, residual_len, &iv)?)),
        ("hammerstein", Box::new(Expanded::new(&curves, inner)?)),
        (
            "scheduled",
            Box::new(RecursiveScheduled::new(&regions, orders, nu, residual_len, local)?),
        ),
    ]);
    Ok(all)
}

fn arx<T: Scalar>(
    orders: ArxOrders,
    nu: usize,
    residual_len: usize,
    kernel: impl RlsKernel<T> + 'static,
) -> Result<Box<dyn Identifier<T>>, Box<dyn Error>> {
    Ok(Box::new(RecursiveArx::new(orders, nu, residual_len, kernel)?))
}

/// Every bias model of this crate, stable, for `nu` inputs within ±1 and `residual_len` residual
/// channels.
///
/// # Errors
///
/// As [`every_identifier`].
pub fn every_bias_model<T: Scalar>(
    orders: ArxOrders,
    nu: usize,
    residual_len: usize,
) -> Result<BiasModels<T>, Box<dyn Error>> {
    let ts = SampleTime::new(0.1)?;
    // Small enough for any orders below ten to be stable.
    let theta = |nu: usize| vec![0.1; residual_len * orders.parameters(nu)];
    let local = ArxModel::new(orders, nu, residual_len, theta(nu), ts)?;
    let regions = Regions::new(0, 5.0, vec![-0.1, 0.1])?;
    let scheduled = ScheduledModel::new(regions, vec![local.clone(), local.clone()])?;
    let curves = curves(nu)?;
    let wide = curves.expanded_len();
    let inner = ArxModel::new(orders, wide, residual_len, theta(wide), ts)?;
    let hammerstein = Expanded::new(&curves, inner.freeze::<T>()?)?;
    let a = Mat::from_fn(2, 2, |i, j| if i == j { 0.5 } else { 0.1 });
    let (b, c) = (Mat::from_fn(2, nu, |_, _| 1.0), Mat::from_fn(residual_len, 2, |_, _| 0.3));
    let d = Mat::from_fn(residual_len, nu, |_, _| 0.1);
    let system = StateSpace::new(a, b, c, d, Discrete { ts })?;
    let states = StateSpaceBias::new(system, vec![0.0; residual_len], &vec![1.0; residual_len])?;
    Ok(vec![
        ("arx", Box::new(local.freeze::<T>()?)),
        ("arx without parameters", Box::new(ArxSimulator::new(orders, nu, residual_len)?)),
        ("hammerstein", Box::new(hammerstein)),
        ("scheduled", Box::new(scheduled.freeze::<T>()?)),
        ("state space", Box::new(states.freeze::<T>()?)),
    ])
}

/// Cubics of inputs between −1 and 1.
fn curves(nu: usize) -> Result<Expansion, Box<dyn Error>> {
    let u: Vec<f64> = [-1.0, 1.0].iter().flat_map(|&v| vec![v; nu]).collect();
    let (inputs, output) = (Channel::numbered("u", nu), Channel::numbered("mu", 1));
    let range = Record::new(inputs, output, u, vec![0.0; 2], SampleTime::new(0.1)?)?;
    Ok(Expansion::from_training(Basis::Polynomial { degree: 3 }, &[range])?)
}
