//! Every residual generator, for tests that must see them all.
//!
//! Only with the feature `testing`. A test of a law walks this list and keeps none of its own, so what
//! is added to it is put to every law.

use faer::Mat;
use fd_model::{Discrete, StateSpace};

use crate::{
    DesignError, GeneratorDesign,
    adaptive::{AdaptiveDesign, ParameterNoise, ParameterShift},
    analysis::UnknownInputs,
    bank::BankDesign,
    decouple::DecoupledDesign,
    directional::BeardDesign,
    eigenstructure::EigenstructureDesign,
    estimation::{FaultEstimatorDesign, FaultNoise},
    observer::{ErrorPoles, ObserverDesign},
    optimal::{Exposure, OptimalDesign},
    parity::ParityDesign,
    simulation::SimulationDesign,
    structured::{RowMethod, Structure, StructuredDesign},
    unknown_input::UnknownInputObserver,
    weighted::{FilteredDesign, WeightedDesign},
    zonotope::{Bounds, ModelBounds, ZonotopeDesign},
};

/// A generator of the list.
#[derive(Debug)]
pub struct Example {
    /// Name of the method; a spec calls it the same where it has a word for it.
    pub name: &'static str,
    /// Samples after which the residual is that of the form.
    pub wait: usize,
    /// Whether it changes with the samples: it has its form only until it has learned something, or only once it
    /// has settled.
    pub adapts: bool,
    /// The design, or why this model does not allow it.
    pub design: Result<Box<dyn GeneratorDesign>, DesignError>,
}

type Design = Result<Box<dyn GeneratorDesign>, DesignError>;
type Make = fn(&StateSpace<Discrete>) -> Design;

/// Every generator of this crate, designed for `model`.
///
/// Some demand more of the model than others: a disturbance to decouple needs an output more, the
/// Beard filter as many outputs as states. What this model does not allow is in the list too, with
/// the reason. A model with as many outputs as states and stable zeros allows all.
#[must_use]
pub fn every_generator(model: &StateSpace<Discrete>) -> Vec<Example> {
    let window = model.nx() + model.ny() + 1;
    let make: [(&'static str, usize, Make); 18] = [
        ("simulation", 0, |m| Ok(Box::new(SimulationDesign::new(m)?))),
        ("observer", 0, |m| Ok(Box::new(ObserverDesign::faster(m, 2.0)?))),
        ("kalman", 0, |m| Ok(Box::new(kalman(m)?))),
        ("parity", model.nx(), |m| Ok(Box::new(ParityDesign::all(m, m.nx())?))),
        ("parity, one row", model.nx(), |m| {
            Ok(Box::new(ParityDesign::all(m, m.nx())?.select(&[0])?))
        }),
        ("unknown-input", 0, |m| {
            let poles = ErrorPoles::Rate(2.0);
            Ok(Box::new(UnknownInputObserver::place(m, direction(m).as_ref(), &poles)?))
        }),
        ("decoupled", 0, |m| {
            let unknown = UnknownInputs::new("d", direction(m), Mat::zeros(m.ny(), 1))?;
            Ok(Box::new(DecoupledDesign::new(m, &unknown, &ErrorPoles::Rate(2.0))?))
        }),
        ("decoupled from nothing", 0, |m| {
            let none = UnknownInputs::none(m);
            Ok(Box::new(DecoupledDesign::new(m, &none, &ErrorPoles::Rate(2.0))?))
        }),
        ("eigenstructure", 0, |m| {
            let poles = ErrorPoles::Rate(2.0);
            Ok(Box::new(EigenstructureDesign::new(m, direction(m).as_ref(), &poles)?))
        }),
        ("optimal", 0, optimal),
        ("structured", window, |m| {
            let (none, longest) = (UnknownInputs::none(m), m.nx() + m.ny());
            let method = RowMethod::Parity { longest };
            let rows = Structure::Dedicated;
            Ok(Box::new(StructuredDesign::new(m, &sensors(m)?, &none, &rows, method)?))
        }),
        ("directional", 0, |m| Ok(Box::new(BeardDesign::full_state(m, 2.0)?))),
        ("adaptive", 0, |m| {
            let noise = ParameterNoise { prior: 0.3, drift: 0.0, output: 0.1, bound: 1.0 };
            Ok(Box::new(AdaptiveDesign::new(kalman(m)?, ParameterShift::input_gains(m), noise)?))
        }),
        ("fault-estimate", 0, |m| {
            let walk = FaultNoise { process: 0.1, output: 0.1, drift: 1.0 };
            Ok(Box::new(FaultEstimatorDesign::new(m, &sensors(m)?, &walk)?))
        }),
        ("zonotope", 0, |m| {
            let disturbance = Mat::from_fn(m.nx(), m.nx(), |i, j| if i == j { 0.1 } else { 0.0 });
            let (noise, model) = (vec![0.1; m.ny()], ModelBounds::exact(m));
            let bounds = Bounds { disturbance, noise, initial: None, model };
            Ok(Box::new(ZonotopeDesign::new(kalman(m)?, bounds, 10 * m.nx())?))
        }),
        ("weighted", 0, |m| {
            Ok(Box::new(WeightedDesign::new(kalman(m)?, mixture(2, m.ny()).as_ref())?))
        }),
        ("filtered", 0, filtered),
        ("bank", model.nx(), |m| {
            let parity = ParityDesign::all(m, m.nx())?;
            let members: Vec<Box<dyn GeneratorDesign>> =
                vec![Box::new(SimulationDesign::new(m)?), Box::new(parity)];
            Ok(Box::new(BankDesign::new(members)?))
        }),
    ];
    let mut all: Vec<Example> = make
        .into_iter()
        .map(|(name, wait, design)| Example {
            name,
            wait,
            adapts: ["adaptive", "zonotope"].contains(&name),
            design: design(model),
        })
        .collect();
    let form = kalman(model).and_then(|kalman| Ok(Box::new(kalman.form()?) as _));
    all.push(Example { name: "form", wait: 0, adapts: false, design: form });
    all
}

fn kalman(model: &StateSpace<Discrete>) -> Result<ObserverDesign, DesignError> {
    ObserverDesign::kalman(model, 1.0, 0.1)
}

fn sensors(model: &StateSpace<Discrete>) -> Result<UnknownInputs, DesignError> {
    (0..model.ny()).try_fold(UnknownInputs::none(model), |all, i| all.sensor(model, i))
}

/// A disturbance that moves all states, the first most.
fn direction(model: &StateSpace<Discrete>) -> Mat<f64> {
    Mat::from_fn(model.nx(), 1, |i, _| 1.0 / (i + 1) as f64)
}

/// Full of numbers and of full rank.
fn mixture(rows: usize, columns: usize) -> Mat<f64> {
    Mat::from_fn(rows, columns, |i, j| if i == j { 1.0 } else { 0.3 - 0.1 * j as f64 })
}

fn optimal(model: &StateSpace<Discrete>) -> Design {
    let (nx, ny) = (model.nx(), model.ny());
    let on = |rows, from| Mat::from_fn(rows, nx + ny, |i, j| if i + from == j { 0.5 } else { 0.0 });
    let noise = UnknownInputs::new("w", on(nx, 0), on(ny, nx))?;
    let (faults, none) = (sensors(model)?, UnknownInputs::none(model));
    let exposure = Exposure { faults: &faults, disturbances: &none, noise: &noise };
    Ok(Box::new(OptimalDesign::new(model, &exposure, 1.0)?))
}

fn filtered(model: &StateSpace<Discrete>) -> Design {
    let ny = model.ny();
    let a = Mat::from_fn(2, 2, |i, j| if i == j { 0.6 } else { -0.1 });
    let (b, c, d) = (mixture(2, ny), mixture(1, 2), mixture(1, ny));
    let filter = StateSpace::new(a, b, c, d, model.domain())?;
    Ok(Box::new(FilteredDesign::new(kalman(model)?, &filter)?))
}
