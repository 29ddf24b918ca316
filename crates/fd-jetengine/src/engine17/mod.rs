//! engine17: a nonlinear two-spool mixed turbofan of the Spey class with seventeen states.
//!
//! Mass and energy are stored in plenums, momentum in ducts, and energy in the shafts; all
//! seventeen states are physical quantities of the gas path. Input: main fuel flow `W_f`.
//! Outputs, as in Patton & Chen (1992): `N_L, N_H, T_7, P_6, T_29`.
//!
//! # What to know before believing a number
//!
//! * `T_29` is taken as the exit temperature of the bypass duct. The paper does not define it;
//!   this is our reading.
//! * Agreement with the published linear Spey model is **not** an independent validation:
//!   volumes, duct ratios and some slopes were back-figured from that model.
//! * Valid for fuel flows of about 0.08 to 1.1 kg/s at sea level; altitudes to 11 km and Mach
//!   numbers to 0.8 with fuel scaled accordingly. No reverse flow. A single fan map. The
//!   temperature behind the low-pressure compressor follows at once.
//! * Derivatives jump where a `max` or choking sets in; linearise away from those points.
//! * Map exponents and guide-vane coefficients were tuned, not measured.
//!
//! Units: rpm, kPa, K, kg/s, s; enthalpies J/kg.

mod auxiliary;
mod combustor;
mod component;
mod compressor;
mod design;
mod discretise;
mod dynamics;
mod environment;
mod extended;
mod gas;
mod health;
mod hpc;
mod jacobian;
mod linearise;
mod lpc;
mod nozzle;
mod params;
mod plenum;
mod power;
mod rhs;
mod scatter;
mod state;
mod transient;
mod trim;
mod turbine;

pub use self::{
    auxiliary::Auxiliary,
    design::Design,
    discretise::{MAX_STEP, PerUnit, Sampled},
    dynamics::{Dynamics, SurgeLimits},
    environment::{Ambient, Environment},
    extended::{ExtendedEngine, NX_EXTENDED, Unmodelled},
    gas::{GAS_CONSTANT, Gas},
    health::{Health, HealthParameter},
    params::{Ducts, HpcMap, LpcMap, Parameters, Reference, TurbineMap, Volumes},
    power::PowerSetting,
    rhs::Engine17,
    state::{MEASURED, NX, NY, State, input_channels, output_channels, state_channels},
    transient::{FuelLimiter, Trajectory, Transient},
    trim::Trim,
};
