//! Logs of an engine with one cause that simulators lack.

use fd_jetengine::engine17::{
    Dynamics, Engine17, ExtendedEngine, Health, HealthParameter, MEASURED, NY, Parameters, Sampled,
    Unmodelled, input_channels, output_channels,
};
use fd_model::{Record, SampleTime, signal::WhiteNoise};
use fdiag::engine_plant::{EngineKnowledge, EnginePlantError, engine_noise};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Integration step of reality, in s.
const STEP: f64 = 1e-3;
/// Part of their tolerance by which the parameters of an engine may differ from nominal.
const SCATTER: f64 = 0.5;
/// Largest change of the fuel flow, relative.
const SWING: f64 = 0.04;

/// What the real engine has and the simulator has not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EngineCause {
    /// Nothing but scatter within the tolerances.
    Nothing,
    /// A shift of a health parameter.
    Health(HealthParameter, f64),
    /// The sensor of this output has a lag, in s.
    SensorLag(usize, f64),
    /// The fuel valve has a lag, in s.
    FuelLag(f64),
    /// The fuel valve is no faster than this, in kg/s per s.
    FuelRateLimit(f64),
    /// The metal takes up heat: multiple of the reference conductance.
    HeatSoak(f64),
}

impl EngineCause {
    /// Label and site of the effect that says so.
    #[must_use]
    pub fn name(self) -> (&'static str, &'static str) {
        const OUTPUTS: [&str; NY] = ["N_L", "N_H", "T_7", "P_6", "T_29"];
        match self {
            Self::Nothing => ("no-gap", ""),
            Self::Health(parameter, _) => {
                let name = parameter.name();
                let label = match parameter {
                    HealthParameter::NozzleArea => "nozzle-area",
                    HealthParameter::BleedLeak => "bleed-leak",
                    HealthParameter::CombustorEfficiency => "combustion",
                    _ if name.ends_with("_flow") => "flow-capacity",
                    _ => "module-efficiency",
                };
                (label, name)
            }
            Self::SensorLag(output, _) => ("sensor-lag", OUTPUTS[output]),
            Self::FuelLag(_) => ("input-lag", "W_f"),
            Self::FuelRateLimit(_) => ("input-rate-limit", "W_f"),
            Self::HeatSoak(_) => ("heat-soak", "metal_conductance"),
        }
    }

    /// Its strength, in the unit of the effect that says so.
    #[must_use]
    pub fn strength(self) -> f64 {
        match self {
            Self::Nothing => 0.0,
            Self::Health(_, x) | Self::SensorLag(_, x) | Self::FuelLag(x) | Self::HeatSoak(x) => x,
            Self::FuelRateLimit(rate) => 1.0 / rate,
        }
    }
}

/// A log of the nonlinear engine with one cause: settled at first, then with steps of the fuel flow
/// of up to 4 %, integrated in steps of 1 ms, with white noise. All modules and the fuel are up to
/// half a tolerance off.
///
/// # Errors
///
/// Returns an error when the engine surges.
pub fn engine_log(
    known: &EngineKnowledge,
    cause: EngineCause,
    samples: usize,
    seed: u64,
) -> Result<Record, EnginePlantError> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut health = Health::default();
    let mut scatter = |parameter, tolerance: f64| {
        let off = SCATTER * tolerance * random.random_range(-1.0..1.0);
        health.set(parameter, health.get(parameter) + off);
    };
    for module in HealthParameter::MODULES {
        scatter(module, known.module_tolerance);
    }
    scatter(HealthParameter::HeatingValue, known.fuel_tolerance);
    if let EngineCause::Health(parameter, shift) = cause {
        health = health.shifted(parameter, shift);
    }
    let fuel = excitation(known, samples, &mut random);
    let engine = Engine17::new(&Parameters::default())?.with_health(health);
    let trim = engine.trim(known.fuel)?;
    let rows = if let EngineCause::HeatSoak(conductance) = cause {
        let reference = Unmodelled::default();
        let soaked = Unmodelled {
            conductance_h: conductance * reference.conductance_h,
            conductance_l: conductance * reference.conductance_l,
            // As short as they can be.
            actuator: STEP,
            temperature_sensor: STEP,
            pressure_sensor: STEP,
            ..reference
        };
        let engine = ExtendedEngine::new(engine, soaked)?;
        let x = engine.equilibrium(&trim);
        run(engine, x, known, cause, &fuel)?
    } else {
        run(engine, trim.x, known, cause, &fuel)?
    };
    let mut y: Vec<f64> = rows.concat();
    for (i, noise) in engine_noise(known)?.into_iter().flatten().enumerate() {
        let noise = WhiteNoise::new(noise, seed * 8 + i as u64).values(samples)?;
        y.iter_mut().skip(i).step_by(NY).zip(noise).for_each(|(y, e)| *y += e);
    }
    Ok(Record::new(input_channels(), output_channels(), fuel, y, known.ts)?)
}

/// The outputs of each sample, as the sensors show them.
fn run<const N: usize>(
    engine: impl Dynamics<f64, N>,
    mut x: [f64; N],
    known: &EngineKnowledge,
    cause: EngineCause,
    fuel: &[f64],
) -> Result<Vec<[f64; NY]>, EnginePlantError> {
    let (ts, step) = (known.ts.seconds(), SampleTime::new(STEP)?);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1")]
    let steps = (ts / STEP).round().max(1.0) as usize;
    let plant = Sampled::<_, N>::new(engine, step);
    let mut valve = known.fuel;
    let mut shown = MEASURED.map(|state| x[state]);
    let mut rows = Vec::with_capacity(fuel.len());
    for demand in fuel {
        rows.push(std::array::from_fn(|i| match cause {
            EngineCause::SensorLag(output, _) if output == i => shown[i],
            _ => x[MEASURED[i]],
        }));
        for _ in 0..steps {
            let before = valve;
            valve = match cause {
                EngineCause::FuelLag(lag) => valve + (demand - valve) * (1.0 - (-STEP / lag).exp()),
                EngineCause::FuelRateLimit(rate) => {
                    valve + (demand - valve).clamp(-rate * STEP, rate * STEP)
                }
                _ => *demand,
            };
            let mean = match cause {
                EngineCause::FuelLag(_) | EngineCause::FuelRateLimit(_) => 0.5 * (before + valve),
                _ => valve,
            };
            let q = MEASURED.map(|state| x[state]);
            x = plant.try_advance(&x, mean)?;
            if let EngineCause::SensorLag(i, lag) = cause {
                let middle = 0.5 * (q[i] + x[MEASURED[i]]);
                shown[i] += (middle - shown[i]) * (1.0 - (-STEP / lag).exp());
            }
        }
    }
    Ok(rows)
}

/// A second at rest, then steps held for 0.4 to 3 s.
fn excitation(
    known: &EngineKnowledge,
    samples: usize,
    random: &mut Xoshiro256PlusPlus,
) -> Vec<f64> {
    let hold = |seconds: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let samples = (seconds / known.ts.seconds()).round() as usize;
        samples.max(1)
    };
    let mut fuel = vec![known.fuel; hold(1.0)];
    while fuel.len() < samples {
        let level = known.fuel * (1.0 + SWING * random.random_range(-1.0..1.0));
        fuel.extend(std::iter::repeat_n(level, hold(random.random_range(0.4..3.0))));
    }
    fuel.truncate(samples);
    fuel
}
