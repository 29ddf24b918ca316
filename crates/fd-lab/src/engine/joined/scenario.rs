//! Which engines: three operating points, a transient, lags that no model knows, and deterioration.

use fd_ident::arx::ArxOrders;
use fd_jetengine::{
    Perturbation,
    engine17::{HealthParameter, Unmodelled},
};
use fdiag::spec::{ApplySpec, BiasSpec, LearningSpec, OrderSpec, PipelineSpec};

use crate::engine::{EngineChoice, EngineConfig, FreshRun, PlantConfig, TrainingRun};

/// A kind of engine, and how it is driven.
#[derive(Clone, Debug)]
pub struct JoinedScenario {
    /// Short name.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// The engine and its runs.
    pub config: EngineConfig,
    /// A shift of a health parameter that the engine has besides its scatter, and that nobody knows.
    pub worn: Option<(HealthParameter, f64)>,
}

/// Scatter of the health of the modules, as a fraction.
pub(super) const SCATTER: f64 = 0.02;

/// All scenarios, in the order of the report.
///
/// ```
/// let names: Vec<&str> = fd_lab::engine::joined::scenarios().iter().map(|s| s.name).collect();
/// assert_eq!(names[..3], ["idle", "middle", "high"]);
/// ```
#[must_use]
pub fn scenarios() -> Vec<JoinedScenario> {
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
    let valve = Unmodelled { actuator: all.actuator, ..none };
    let scenario = |name, about, fuel, unmodelled, worn| JoinedScenario {
        name,
        about,
        config: config(fuel, unmodelled, 1.0),
        worn,
    };
    let transient = JoinedScenario {
        name: "transient",
        about: "0.712 kg/s, fuel moves by up to 30 %",
        config: config(0.712, None, 4.0),
        worn: None,
    };
    let hpc = Some((HealthParameter::HpcEfficiency, -0.03));
    vec![
        scenario("idle", "0.40 kg/s", 0.40, None, None),
        scenario("middle", "0.712 kg/s", 0.712, None, None),
        scenario("high", "0.95 kg/s", 0.95, None, None),
        transient,
        scenario("valve-lag", "the fuel valve lags, 0.1 s", 0.712, Some(valve), None),
        scenario(
            "sensor-lag",
            "sensors of T and P lag, 0.7 and 0.04 s",
            0.712,
            Some(sensors),
            None,
        ),
        scenario("heat-soak", "the turbine metal takes up heat", 0.712, Some(soaked), None),
        scenario("all-lags", "valve, sensors and metal together", 0.712, Some(all), None),
        scenario("deteriorated", "the HPC has lost 3 % more efficiency", 0.712, None, hpc),
    ]
}

/// A nonlinear engine with a linear model that is exact at the nominal engine, driven `swing` times as far as
/// `examples/engine/nonlinear-ref.toml` does.
fn config(fuel_kg_s: f64, unmodelled: Option<Unmodelled>, swing: f64) -> EngineConfig {
    let engine = EngineChoice::Engine17Nonlinear {
        fuel_kg_s,
        moved_to_kg_s: None,
        health_scatter: SCATTER,
        unmodelled,
    };
    let default = EngineConfig::default();
    EngineConfig {
        plant: PlantConfig { engine, perturbation: Perturbation::None {}, ..default.plant },
        training: TrainingRun {
            level: 0.025 * swing,
            steps: [(12.0, -0.034), (24.0, 0.029), (36.0, -0.023), (48.0, 0.025)]
                .map(|(at, height)| (at, height * swing))
                .to_vec(),
            tone_amplitude: 0.0033 * swing,
            ..default.training
        },
        fresh: FreshRun {
            level: 0.025 * swing,
            step: 0.025 * swing,
            tone_amplitude: 0.005 * swing,
            ..default.fresh
        },
        pipeline: PipelineSpec {
            weighting: None,
            bias: BiasSpec {
                orders: OrderSpec::Fixed(ArxOrders { offset: true, ..ArxOrders::paper(2) }),
                learning: LearningSpec::Batch { prefilter_rad_s: Some(8.0) },
                apply: ApplySpec::Always,
                ..BiasSpec::default()
            },
            ..default.pipeline
        },
        ..default
    }
}
