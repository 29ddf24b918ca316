//! The scenarios and methods of a comparison that was asked for nothing special.

use fd_compensate::{
    calibrate::FalseAlarms,
    detect::{
        glr::Course,
        sprt::{ErrorProbabilities, Sides},
    },
};
use fd_ident::{arx::ArxOrders, hammerstein::Basis};
use fd_jetengine::{Perturbation, engine17::Unmodelled};
use fd_model::fault::Site;
use fdiag::spec::{
    AdaptiveSpec, ApplySpec, BiasSpec, BoundSpec, DetectorSpec, DisturbanceSpec, GeneratorSpec,
    LearningSpec, OrderSpec, ParameterSpec, StructureSpec,
};

use super::{
    method::{Bias, Detector, Generator},
    scenario::{Present, Scenario},
};
use crate::engine::{EngineChoice, PlantConfig};

/// The linear engine, the nonlinear one where it is modelled, moved, and with dynamics that no model
/// knows; noise; and the cases in which compensation must lose.
pub(super) fn scenarios() -> Vec<Scenario> {
    let nonlinear = |fuel_kg_s, moved_to_kg_s, unmodelled| PlantConfig {
        engine: EngineChoice::Engine17Nonlinear {
            fuel_kg_s,
            moved_to_kg_s,
            health_scatter: 0.02,
            unmodelled,
        },
        perturbation: Perturbation::None {},
        ..PlantConfig::default()
    };
    let none = Unmodelled {
        actuator: 0.0,
        conductance_h: 0.0,
        conductance_l: 0.0,
        temperature_sensor: 0.0,
        pressure_sensor: 0.0,
        ..Unmodelled::default()
    };
    let all = Unmodelled::default();
    let sensors = Unmodelled {
        temperature_sensor: all.temperature_sensor,
        pressure_sensor: all.pressure_sensor,
        ..none
    };
    let soaked =
        Unmodelled { conductance_h: all.conductance_h, conductance_l: all.conductance_l, ..none };
    let reference = 0.712;
    let t_7 = |while_learning| Present { site: Site::sensor("T_7"), size: 0.01, while_learning };
    let worn = |while_learning| Present {
        site: Site::component("hpc_efficiency"),
        size: -0.01,
        while_learning,
    };
    let scenario = |name: &str, about: &str, plant, present| Scenario {
        name: name.to_owned(),
        about: about.to_owned(),
        plant,
        own: None,
        present,
    };
    let noise = |noise| PlantConfig { noise, ..PlantConfig::default() };
    vec![
        scenario("linear", "the paper's case: A and B 10 % wrong", noise(5e-4), None),
        scenario("linear-noisy", "the same with four times the noise", noise(2e-3), None),
        scenario("idle", "nonlinear at 0.40 kg/s", nonlinear(0.40, None, None), None),
        scenario("middle", "nonlinear at 0.712 kg/s", nonlinear(reference, None, None), None),
        scenario("high", "nonlinear at 0.95 kg/s", nonlinear(0.95, None, None), None),
        scenario(
            "valve-lag",
            "the fuel valve lags, 0.1 s",
            nonlinear(reference, None, Some(Unmodelled { actuator: all.actuator, ..none })),
            None,
        ),
        scenario(
            "sensor-lag",
            "the sensors of temperatures and pressure lag, 0.7 and 0.04 s",
            nonlinear(reference, None, Some(sensors)),
            None,
        ),
        scenario(
            "heat-soak",
            "the turbine metal takes up heat",
            nonlinear(reference, None, Some(soaked)),
            None,
        ),
        scenario(
            "all-lags",
            "valve, sensors and metal together",
            nonlinear(reference, None, Some(all)),
            None,
        ),
        scenario(
            "moved",
            "10 % more fuel after thresholds were set",
            nonlinear(reference, Some(1.1 * reference), None),
            None,
        ),
        scenario(
            "fault-learned",
            "T_7 reads 1 % too much while the bias is learned and for ever after",
            nonlinear(reference, None, None),
            Some(t_7(true)),
        ),
        scenario(
            "deteriorated",
            "the high-pressure compressor has lost 1 % after the bias was learned",
            nonlinear(reference, None, None),
            Some(worn(false)),
        ),
        scenario(
            "deterioration-learned",
            "it has lost 1 % before the bias was learned, or learned again",
            nonlinear(reference, None, None),
            Some(worn(true)),
        ),
    ]
}

/// Variances per sample that the noise of the benchmark amounts to, in units of the readings.
const PROCESS_NOISE: f64 = 1e-6;
const OUTPUT_NOISE: f64 = 2.5e-7;
/// Rate of observers in 1/s: near the slowest mode of the engine, which keeps the bias in few slow
/// modes.
const RATE: f64 = 2.0;

pub(super) fn generators() -> Vec<Generator> {
    let all = |name: &str, spec| Generator {
        name: name.to_owned(),
        spec,
        weighting: None,
        diagnose_s: None,
    };
    let learned = || DisturbanceSpec::Learned { rank: 2, duration_s: None, output_noise: 0.1 };
    let (process_noise, output_noise, rate) = (PROCESS_NOISE, OUTPUT_NOISE, RATE);
    let adaptive = |parameters| GeneratorSpec::Adaptive {
        parameters,
        process_noise: process_noise / output_noise,
        output_noise,
        prior: 0.1,
        drift: 1e-8,
        bound: 0.5,
    };
    vec![
        all("simulation", GeneratorSpec::Simulation {}),
        all("observer", GeneratorSpec::Observer { rate }),
        Generator {
            name: "observer-sum".to_owned(),
            spec: GeneratorSpec::Observer { rate },
            weighting: Some(vec![vec![1.0; 5]]),
            diagnose_s: None,
        },
        all("kalman", GeneratorSpec::Kalman { process_noise, output_noise }),
        all("parity", GeneratorSpec::Parity { order: 2 }),
        all("unknown-input", GeneratorSpec::UnknownInput { disturbance: learned(), rate }),
        all("decoupled", GeneratorSpec::Decoupled { disturbance: learned(), rate }),
        all(
            "optimal",
            GeneratorSpec::Optimal {
                faults: Vec::new(),
                process_noise,
                output_noise,
                decoupled: None,
                attenuated: Some(learned()),
                rate,
            },
        ),
        all("adaptive-gain", adaptive(ParameterSpec::InputGains {})),
        all("adaptive-rates", adaptive(ParameterSpec::StateRates {})),
    ]
}

pub(super) fn biases() -> Vec<Bias> {
    let learned = |name: &str, structure, learning| Bias {
        name: name.to_owned(),
        spec: Some(BiasSpec {
            structure,
            orders: OrderSpec::Fixed(ArxOrders::paper(2)),
            learning,
            apply: ApplySpec::Always,
        }),
    };
    let linear = StructureSpec::Linear;
    let filtered = LearningSpec::Batch { prefilter_rad_s: Some(8.0) };
    let bent = StructureSpec::Hammerstein { basis: Basis::Polynomial { degree: 2 } };
    vec![
        Bias { name: "none".to_owned(), spec: None },
        learned("arx", linear.clone(), LearningSpec::default()),
        learned("arx-filtered", linear.clone(), filtered.clone()),
        learned("output-error", linear, LearningSpec::OutputError { from_rest: true }),
        learned("hammerstein", bent, filtered),
    ]
}

pub(super) fn detectors() -> Vec<Detector> {
    let rare = FalseAlarms::PerSample { rate: 0.01 };
    let bound = AdaptiveSpec {
        bound: BoundSpec::Learned { quantile: 0.99 },
        corners: 4,
        slowest_samples: 100.0,
        memory_samples: 50.0,
        void_margin: 0.1,
        false_alarms: rare,
    };
    let detector = |name: &str, spec| Detector { name: name.to_owned(), spec };
    vec![
        detector("maximum", DetectorSpec::default()),
        detector("n-sigma", DetectorSpec::NSigma { sigmas: 3.0, false_alarms: None }),
        detector("chi-square", DetectorSpec::ChiSquare { window: 20, false_alarms: rare }),
        detector("cusum", DetectorSpec::Cusum { reference: 0.5, false_alarms: rare }),
        detector(
            "sprt",
            DetectorSpec::Sprt {
                shift: 1.0,
                errors: ErrorProbabilities { false_alarm: 0.01, missed: 0.05 },
                sides: Sides::Both,
                false_alarms: None,
            },
        ),
        detector(
            "glr",
            DetectorSpec::Glr {
                window: 50,
                courses: vec![Course::Step],
                whitening: 10,
                faults: None,
                false_alarms: rare,
            },
        ),
        detector("adaptive", DetectorSpec::AdaptiveThreshold(bound.clone())),
        detector("selector", DetectorSpec::ThresholdSelector(bound)),
    ]
}
