//! What several benchmarks are run on: the paper's engine, its 5-state model, and random plants.
#![allow(clippy::missing_errors_doc, reason = "a benchmark stops at the first error")]
#![allow(clippy::missing_panics_doc, reason = "a benchmark stops at the first error")]

use std::{error::Error, time::Duration};

use faer::{Mat, c64, mat};
use fd_lab::engine::TrainingRun;
use fdiag::{
    core::Heap,
    jetengine::{
        EngineModel, Perturbation,
        engine17::{Engine17, Parameters, PowerSetting},
    },
    model::{
        Continuous, Discrete, Record, SampleTime, Simulation, StateSpace, reduce,
        signal::WhiteNoise, uncertainty::MatrixPerturbation,
    },
    residual::{GeneratorDesign, observer::ObserverDesign, weighted::WeightedDesign},
    training::residual_record,
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

mod limit;

pub use crate::limit::{Work, fused_multiply_adds};

/// Whatever can go wrong before a benchmark starts.
pub type Fallible<T> = Result<T, Box<dyn Error>>;

/// How long each figure is waited for: a warm-up, then the measurement.
pub const WARM_UP: Duration = Duration::from_millis(300);
/// See [`WARM_UP`].
pub const MEASUREMENT: Duration = Duration::from_secs(1);
/// Samples that criterion takes of each figure.
pub const SAMPLES: usize = 20;

/// The states of engine17 that are measured, in the order of the outputs.
const MEASURED_STATES: usize = 5;

/// The paper's case as `fdiag-lab engine` has it by default: 60 s of a perturbed 17-state engine, its
/// sensors noisy, and the observer of the nominal 5-state model that watches it.
pub struct PaperCase {
    /// Inputs and outputs of the healthy engine: 1200 samples.
    pub record: Record,
    /// The observer before its weighting.
    pub observer: ObserverDesign,
    /// The observer with `W = [1 1 1 1 1]`.
    pub generator: WeightedDesign<ObserverDesign>,
    /// Input and weighted residual of `record`.
    pub residual: Record,
}

impl PaperCase {
    /// Simulates the engine and designs the observer.
    pub fn new() -> Fallible<Self> {
        let ts = SampleTime::new(0.05)?;
        let nominal = nominal_engine()?;
        let perturbation = MatrixPerturbation {
            matrices: [true, true, false, false],
            ..MatrixPerturbation::default()
        };
        let plant = Perturbation::Matrices(perturbation).draw(&nominal, 1)?.model.model;
        let plant = plant.sample_zoh(ts)?.freeze::<f64, Heap>()?;
        let inputs = TrainingRun::default().inputs(&nominal.inputs, ts)?;
        let noise = |seed| WhiteNoise::new(5e-4, seed).into();
        let output_noise = (0..nominal.outputs.len() as u64).map(noise).collect();
        let simulation = Simulation { output_noise, ..Simulation::default() };
        let record = simulation.run(&plant, &inputs, nominal.outputs.clone())?;

        let model = reduced(&nominal.model)?.sample_zoh(ts)?;
        let pole = c64::new((-2.0 * ts.seconds()).exp(), 0.0);
        let observer = ObserverDesign::place(&model, &[pole; MEASURED_STATES])?;
        let ones = mat![[1.0, 1.0, 1.0, 1.0, 1.0]];
        let generator = WeightedDesign::new(observer.clone(), ones.as_ref())?;
        let residual = residual_record(generator.build()?.as_mut(), &record, 0)?;
        Ok(Self { record, observer, generator, residual })
    }
}

/// engine17 at the reference point, linear and per unit.
pub fn nominal_engine() -> Fallible<EngineModel> {
    let engine = Engine17::new(&Parameters::default())?;
    let trim = engine.trim(PowerSetting::Reference.fuel())?;
    Ok(engine.linearise(&trim)?.per_unit()?)
}

/// The model onto the states that its outputs measure.
pub fn reduced(model: &StateSpace<Continuous>) -> Fallible<StateSpace<Continuous>> {
    let kept: Vec<usize> = (0..model.ny())
        .filter_map(|row| (0..model.nx()).find(|&column| model.c()[(row, column)].abs() > 0.0))
        .collect();
    Ok(reduce::residualise_onto(model, &kept)?)
}

/// A random plant with `nx` states, 2 inputs and 3 outputs whose slowest pole lies at 0.95.
pub fn random_plant(nx: usize, seed: u64) -> Fallible<StateSpace<Discrete>> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut uniform =
        |rows, columns| Mat::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0));
    let (a, b, c): (Mat<f64>, _, _) = (uniform(nx, nx), uniform(nx, 2), uniform(3, nx));
    let domain = Discrete { ts: SampleTime::new(0.1)? };
    let raw = StateSpace::new(a.clone(), b.clone(), c.clone(), Mat::zeros(3, 2), domain)?;
    let radius = raw.worst_pole()?.map_or(1.0, c64::norm);
    let a = Mat::from_fn(nx, nx, |i, j| 0.95 / radius * a[(i, j)]);
    Ok(StateSpace::new(a, b, c, Mat::zeros(3, 2), domain)?)
}
