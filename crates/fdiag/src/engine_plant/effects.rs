//! Effects of engines: wear, leaks, combustion, heat soak.

use fd_effect::{Effect, NotTestable, Offers, Reason, SiteRef, Sketch, input, sensor};
use fd_sim::{model::Model, scales::ReplayScales};

use super::METAL_CONDUCTANCE;

/// A change of some parameters of the engine, each on its own: `p + e`.
///
/// The names of parameters are those of [`Health`](fd_jetengine::engine17::Health).
#[derive(Clone, Copy, Debug)]
pub struct EngineEffect {
    label: &'static str,
    family: &'static str,
    parameters: &'static [&'static str],
    /// One unit of a fit, and bounds in such units.
    scale: f64,
    bounds: [f64; 2],
    starts: &'static [f64],
}

/// Efficiency of a compressor or turbine, as a shift of the factor on it.
pub const MODULE_EFFICIENCY: EngineEffect = EngineEffect {
    label: "module-efficiency",
    family: "module",
    parameters: &["lpc_efficiency", "hpc_efficiency", "hpt_efficiency", "lpt_efficiency"],
    scale: 0.01,
    bounds: [-10.0, 5.0],
    starts: &[-1.0, 0.5],
};

/// Flow capacity of a compressor or turbine, as a shift of the factor on it.
pub const FLOW_CAPACITY: EngineEffect = EngineEffect {
    label: "flow-capacity",
    family: "module",
    parameters: &["lpc_flow", "hpc_flow", "hpt_flow", "lpt_flow"],
    scale: 0.01,
    bounds: [-10.0, 10.0],
    starts: &[-1.0, 1.0],
};

/// A leak of delivery air overboard, as a fraction of the compressor flow.
pub const BLEED_LEAK: EngineEffect = EngineEffect {
    label: "bleed-leak",
    family: "bleed",
    parameters: &["bleed_leak"],
    scale: 0.01,
    bounds: [0.0, 10.0],
    starts: &[0.5],
};

/// Area of the nozzle throat, as a shift of the factor on it.
pub const NOZZLE_AREA: EngineEffect = EngineEffect {
    label: "nozzle-area",
    family: "nozzle",
    parameters: &["nozzle_area"],
    scale: 0.01,
    bounds: [-10.0, 10.0],
    starts: &[-1.0, 1.0],
};

/// Combustor efficiency, which no measurement tells from the heating value of the fuel.
pub const COMBUSTION: EngineEffect = EngineEffect {
    label: "combustion",
    family: "combustion",
    parameters: &["combustor_efficiency"],
    scale: 0.01,
    bounds: [-10.0, 5.0],
    starts: &[-1.0, 0.5],
};

/// Heat that the metal of the turbines takes up and gives back, as a multiple of a reference
/// conductance.
pub const HEAT_SOAK: EngineEffect = EngineEffect {
    label: "heat-soak",
    family: "heat-soak",
    parameters: &[METAL_CONDUCTANCE],
    scale: 1.0,
    bounds: [0.0, 5.0],
    starts: &[0.2, 1.0],
};

impl Effect for EngineEffect {
    fn label(&self) -> &'static str {
        self.label
    }

    fn family(&self) -> &'static str {
        self.family
    }

    fn is_signed(&self) -> bool {
        self.bounds[0] < 0.0
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let offers = self.parameters.iter().map(|name| {
            let parameter = nominal.parameters.iter().position(|known| known.name == *name);
            let Some(i) = parameter else {
                return Err(NotTestable {
                    label: self.label,
                    law: "constant",
                    site: SiteRef::WholeModel,
                    reason: Box::new(Reason::Missing("such parameter")),
                });
            };
            let sketch = Sketch::of_parameter(self, "constant", nominal, scales, i);
            let sketch = sketch.strength("e", "shift", "1", self.scale, self.bounds);
            let sketch = sketch.wrap_parameter("p + e");
            self.starts.iter().fold(sketch, |sketch, start| sketch.start(&[*start])).finish()
        });
        offers.collect()
    }
}

/// What engines suffer from: changes of the engine, and what happens to fuel valves and sensors.
#[must_use]
pub fn engine_effects() -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(MODULE_EFFICIENCY),
        Box::new(FLOW_CAPACITY),
        Box::new(BLEED_LEAK),
        Box::new(NOZZLE_AREA),
        Box::new(COMBUSTION),
        Box::new(HEAT_SOAK),
        Box::new(input::InputGain),
        Box::new(input::InputOffset),
        Box::new(input::InputBacklash),
        Box::new(input::InputDelay),
        Box::new(input::InputLag),
        Box::new(input::InputRateLimit),
        Box::new(sensor::SensorBias),
        Box::new(sensor::SensorDrift),
        Box::new(sensor::SensorScale),
        Box::new(sensor::SensorLag),
        Box::new(sensor::SensorDelay),
    ]
}
