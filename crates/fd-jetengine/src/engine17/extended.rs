//! The engine with what the seventeen states leave out: fuel actuator, hot metal, sensor lags.

use fd_core::Scalar;
use fd_model::Channel;
use serde::{Deserialize, Serialize};

use super::{
    auxiliary::Auxiliary,
    dynamics::{Dynamics, SurgeLimits},
    gas::k,
    linearise::linearise,
    rhs::Engine17,
    state::{NX, NY, state_channels},
    trim::Trim,
};
use crate::{error::EngineError, model::EngineModel};

/// Number of states of the extended engine.
pub const NX_EXTENDED: usize = 23;

/// Index of the actuator's fuel flow; then two metal temperatures and three sensor readings.
const ACTUATOR: usize = NX;
const METAL: [usize; 2] = [NX + 1, NX + 2];
/// Readings of `T_7`, `P_6` and `T_29`.
const SENSORS: [usize; 3] = [NX + 3, NX + 4, NX + 5];
/// States that the sensors read.
const SENSED: [usize; 3] = [16, 8, 13];
/// States of the gas that heats the metal: `T_4` and `T_5`, at the inlets of the turbines.
const HEATING: [usize; 2] = [5, 7];
/// Index of `W_6`.
const W_6: usize = 10;

/// Sizes of the dynamics that engine17 leaves out.
///
/// Lags are those of published engine codes. Masses and conductances of the metal are guesses
/// of the right size. Speeds are read without lag (0.02 s in published codes), and the 40 ms
/// dead time of the fuel valve is left to the caller, who can delay the input.
///
/// A lag of 0 s and a conductance of 0 W/K leave that part out: its state then stays where it is,
/// so that the linear model has a pole at zero for it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Unmodelled {
    /// Time constant of the fuel actuator, s. Default 0.1.
    pub actuator: f64,
    /// Mass of the high-pressure turbine metal, kg. Default 45.
    pub metal_mass_h: f64,
    /// Mass of the low-pressure turbine metal, kg. Default 60.
    pub metal_mass_l: f64,
    /// Heat capacity of the metal, J/(kg K). Default 500.
    pub metal_heat: f64,
    /// Conductance from gas to high-pressure turbine metal at the reference flow, W/K.
    /// Default 6000; it follows the 0.8th power of the flow.
    pub conductance_h: f64,
    /// Conductance from gas to low-pressure turbine metal, W/K. Default 4000.
    pub conductance_l: f64,
    /// Time constant of the temperature sensors, s. Default 0.7.
    pub temperature_sensor: f64,
    /// Time constant of the pressure sensor, s. Default 0.04.
    pub pressure_sensor: f64,
}

impl Default for Unmodelled {
    fn default() -> Self {
        Self {
            actuator: 0.1,
            metal_mass_h: 45.0,
            metal_mass_l: 60.0,
            metal_heat: 500.0,
            conductance_h: 6000.0,
            conductance_l: 4000.0,
            temperature_sensor: 0.7,
            pressure_sensor: 0.04,
        }
    }
}

/// engine17 with six more states: fuel actuator, metal of both turbines, readings of
/// `T_7, P_6, T_29`.
///
/// ```
/// use fd_jetengine::engine17::{Engine17, ExtendedEngine, Parameters, Unmodelled};
///
/// let engine = Engine17::new(&Parameters::default())?;
/// let trim = engine.trim(0.712)?;
/// let extended = ExtendedEngine::new(engine, Unmodelled::default())?;
/// assert!(extended.linearise(&trim)?.model.is_stable()?);
/// # Ok::<(), fd_jetengine::EngineError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ExtendedEngine<T: Scalar = f64> {
    engine: Engine17<T>,
    /// Rates of first-order lags in 1/s; none where there is no lag.
    actuator_rate: Option<T>,
    conductance: [T; 2],
    metal_capacity: [T; 2],
    sensor_rates: [Option<T>; 3],
    reference_flow: T,
}

impl<T: Scalar> ExtendedEngine<T> {
    /// Extends an engine.
    ///
    /// # Errors
    ///
    /// Returns an error when a mass or capacity is not positive, a conductance is negative, or a time
    /// constant is neither 0 nor at least 1 ms.
    pub fn new(engine: Engine17<T>, with: Unmodelled) -> Result<Self, EngineError> {
        let absent = |value: f64| value.total_cmp(&0.0).is_eq();
        let (always, or_none) = (false, true);
        for (quantity, value, unit, optional) in [
            ("time constant of the fuel actuator", with.actuator, "s", or_none),
            ("mass of the high-pressure turbine metal", with.metal_mass_h, "kg", always),
            ("mass of the low-pressure turbine metal", with.metal_mass_l, "kg", always),
            ("heat capacity of the metal", with.metal_heat, "J/(kg K)", always),
            ("conductance to the high-pressure turbine metal", with.conductance_h, "W/K", or_none),
            ("conductance to the low-pressure turbine metal", with.conductance_l, "W/K", or_none),
            ("time constant of the temperature sensors", with.temperature_sensor, "s", or_none),
            ("time constant of the pressure sensor", with.pressure_sensor, "s", or_none),
        ] {
            let (low, high) = (1e-3, 1e9);
            if !((low..=high).contains(&value) || optional && absent(value)) {
                return Err(EngineError::OutOfRange { quantity, value, low, high, unit });
            }
        }
        let rate = |lag: f64| (!absent(lag)).then(|| k::<T>(1.0 / lag));
        let temperature = rate(with.temperature_sensor);
        Ok(Self {
            reference_flow: k(engine.design().reference.w_6),
            engine,
            actuator_rate: rate(with.actuator),
            conductance: [k(with.conductance_h), k(with.conductance_l)],
            metal_capacity: [
                k(with.metal_mass_h * with.metal_heat),
                k(with.metal_mass_l * with.metal_heat),
            ],
            sensor_rates: [temperature, rate(with.pressure_sensor), temperature],
        })
    }

    /// The engine inside.
    #[must_use]
    pub fn engine(&self) -> &Engine17<T> {
        &self.engine
    }

    /// The engine inside, for instance to change its health.
    pub fn engine_mut(&mut self) -> &mut Engine17<T> {
        &mut self.engine
    }
}

impl ExtendedEngine<f64> {
    /// The equilibrium that belongs to one of the engine inside: metal as hot as its gas,
    /// sensors and actuator settled.
    #[must_use]
    pub fn equilibrium(&self, trim: &Trim) -> [f64; NX_EXTENDED] {
        let mut x = [0.0; NX_EXTENDED];
        x[..NX].copy_from_slice(&trim.x);
        x[ACTUATOR] = trim.fuel;
        for (state, source) in METAL.into_iter().zip(HEATING).chain(SENSORS.into_iter().zip(SENSED))
        {
            x[state] = trim.x[source];
        }
        x
    }

    /// The linear model about an equilibrium of the engine inside, in physical units.
    ///
    /// # Errors
    ///
    /// Returns an error when a derivative is not finite.
    pub fn linearise(&self, trim: &Trim) -> Result<EngineModel, EngineError> {
        let mut states = state_channels();
        states.extend(
            [
                ("W_f actuator", "kg/s"),
                ("T metal HPT", "K"),
                ("T metal LPT", "K"),
                ("T_7 sensor", "K"),
                ("P_6 sensor", "kPa"),
                ("T_29 sensor", "K"),
            ]
            .map(|(name, unit)| Channel::new(name, unit)),
        );
        let name = format!("engine17 with unmodelled dynamics at {} kg/s", trim.fuel);
        linearise::<NX_EXTENDED>(self, &self.equilibrium(trim), trim.fuel, states, name)
    }
}

impl<T: Scalar> Dynamics<T, NX_EXTENDED> for ExtendedEngine<T> {
    fn rates(&self, x: &[T; NX_EXTENDED], fuel: T) -> ([T; NX_EXTENDED], Auxiliary<T>) {
        let core: [T; NX] = std::array::from_fn(|i| x[i]);
        let flow = (x[W_6] / self.reference_flow).max(T::zero()).powf(k(0.8));
        let heat: [T; 2] =
            std::array::from_fn(|i| self.conductance[i] * flow * (x[METAL[i]] - x[HEATING[i]]));
        let burnt = if self.actuator_rate.is_some() { x[ACTUATOR] } else { fuel };
        let (core_rates, auxiliary) = self.engine.rates_with_heat(&core, burnt, heat);
        let mut rates = [T::zero(); NX_EXTENDED];
        rates[..NX].copy_from_slice(&core_rates);
        let lag =
            |rate: Option<T>, from: T, to: T| rate.map_or(T::zero(), |rate| (to - from) * rate);
        rates[ACTUATOR] = lag(self.actuator_rate, x[ACTUATOR], fuel);
        for i in 0..2 {
            rates[METAL[i]] = -heat[i] / self.metal_capacity[i];
        }
        for i in 0..3 {
            rates[SENSORS[i]] = lag(self.sensor_rates[i], x[SENSORS[i]], x[SENSED[i]]);
        }
        (rates, auxiliary)
    }

    fn surge_limits(&self) -> SurgeLimits<T> {
        self.engine.surge_limits()
    }

    fn measured(&self) -> [usize; NY] {
        let reading =
            |i: usize| if self.sensor_rates[i].is_some() { SENSORS[i] } else { SENSED[i] };
        [0, 1, reading(0), reading(1), reading(2)]
    }
}
