//! What defines the engine: a reference point, volumes, ducts, inertias and map shapes.

use serde::{Deserialize, Serialize};

/// Parameters of the engine with the values of the reference engine as defaults.
///
/// The reference point is that of a published linear Spey model where it prints one. Volumes,
/// duct ratios `A/L` and some slopes were back-figured from that model, and map exponents and
/// guide-vane coefficients were tuned, not measured: agreement with the Spey matrices is
/// therefore *not* an independent validation.
///
/// ```
/// use fd_jetengine::engine17::Parameters;
///
/// let heavy = Parameters { inertia_h: 9.0, ..Parameters::default() };
/// assert!(heavy.design().is_ok());
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Values at the reference point.
    pub reference: Reference,
    /// Total pressure recovery of the intake. Default 0.990.
    pub ram_recovery: f64,
    /// `(π_outer - 1) / (π_inner - 1)` of the low-pressure compressor. Default 0.955.
    pub outer_stream: f64,
    /// Reference efficiency of the low-pressure compressor. Default 0.875.
    pub lpc_efficiency: f64,
    /// Reference efficiency of the high-pressure compressor. Default 0.855.
    pub hpc_efficiency: f64,
    /// Turbine cooling air as a fraction of the high-pressure compressor flow. Default 0.080.
    pub cooling: f64,
    /// Overboard bleed as a fraction of the high-pressure compressor flow. Default 0.0135.
    pub overboard_bleed: f64,
    /// Relative pressure loss of the combustor at the reference point. Default 0.05.
    pub combustor_loss: f64,
    /// Combustor efficiency. Default 0.995.
    pub combustor_efficiency: f64,
    /// Lower heating value of the fuel, J/kg. Default 43.1e6.
    pub heating_value: f64,
    /// Sensible enthalpy of the fuel and correction of the enthalpy datum, J/kg. Default 0.34e6.
    pub fuel_enthalpy: f64,
    /// Mechanical efficiency of both shafts. Default 0.99.
    pub mechanical_efficiency: f64,
    /// Power of the accessories at the reference speed of the high-pressure shaft, W.
    /// Default 60e3.
    pub accessory_power: f64,
    /// Moment of inertia of the low-pressure shaft, kg m². Default 5.5.
    pub inertia_l: f64,
    /// Moment of inertia of the high-pressure shaft, kg m². Default 7.5.
    pub inertia_h: f64,
    /// Area of the jet pipe at the mixing plane, m². Default 0.50.
    pub jet_pipe_area: f64,
    /// Volumes of the plenums.
    pub volumes: Volumes,
    /// Area over length of the ducts.
    pub ducts: Ducts,
    /// Shape of the low-pressure compressor map.
    pub lpc: LpcMap,
    /// Shape of the high-pressure compressor map.
    pub hpc: HpcMap,
    /// Shape of the high-pressure turbine map. Default critical ratio 0.42.
    pub hpt: TurbineMap,
    /// Shape of the low-pressure turbine map. Default critical ratio 0.35.
    pub lpt: TurbineMap,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            reference: Reference::default(),
            ram_recovery: 0.990,
            outer_stream: 0.955,
            lpc_efficiency: 0.875,
            hpc_efficiency: 0.855,
            cooling: 0.080,
            overboard_bleed: 0.0135,
            combustor_loss: 0.05,
            combustor_efficiency: 0.995,
            heating_value: 43.1e6,
            fuel_enthalpy: 0.34e6,
            mechanical_efficiency: 0.99,
            accessory_power: 60e3,
            inertia_l: 5.5,
            inertia_h: 7.5,
            jet_pipe_area: 0.50,
            volumes: Volumes::default(),
            ducts: Ducts::default(),
            lpc: LpcMap::default(),
            hpc: HpcMap::default(),
            hpt: TurbineMap { critical_ratio: 0.42, efficiency_curvature: 0.35 },
            lpt: TurbineMap { critical_ratio: 0.35, efficiency_curvature: 0.35 },
        }
    }
}

/// The point at which the engine is in equilibrium by construction (sea level, static).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Reference {
    /// Low-pressure shaft speed, rpm. Default 7251.3.
    pub n_l: f64,
    /// High-pressure shaft speed, rpm. Default 11767.1.
    pub n_h: f64,
    /// Core air flow, kg/s. Default 46.614.
    pub w_2: f64,
    /// Bypass air flow, kg/s. Default 27.783.
    pub w_b: f64,
    /// Pressure at the high-pressure compressor inlet, kPa. Default 243.203.
    pub p_2: f64,
    /// Pressure at the high-pressure compressor delivery, kPa. Default 1485.35.
    pub p_3: f64,
    /// Pressure between the turbines, kPa. Default 443.831.
    pub p_5: f64,
    /// Pressure at the low-pressure turbine exit, kPa. Default 234.5 (published: 239.1, which
    /// with the published fuel flow would need a low-pressure turbine efficiency of 0.97).
    pub p_6: f64,
    /// Pressure of the bypass duct, kPa. Default 234.362.
    pub p_29: f64,
    /// Static pressure of the jet pipe, kPa. Default 219.237.
    pub ps_7: f64,
    /// Main fuel flow, kg/s. Default 0.712 (published: 0.685; changed with `p_6` so that
    /// temperatures land on the published 1273 K and 675 K).
    pub fuel: f64,
}

impl Default for Reference {
    fn default() -> Self {
        Self {
            n_l: 7251.3,
            n_h: 11_767.1,
            w_2: 46.614,
            w_b: 27.783,
            p_2: 243.203,
            p_3: 1485.35,
            p_5: 443.831,
            p_6: 234.5,
            p_29: 234.362,
            ps_7: 219.237,
            fuel: 0.712,
        }
    }
}

/// Volumes of the plenums, m³.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Volumes {
    /// High-pressure compressor inlet. Default 0.275.
    pub hpc_inlet: f64,
    /// Combustor. Default 0.122.
    pub combustor: f64,
    /// Between the turbines. Default 0.237.
    pub inter_turbine: f64,
    /// Low-pressure turbine exit. Default 0.324.
    pub turbine_exit: f64,
    /// Bypass duct. Default 0.855.
    pub bypass: f64,
    /// Jet pipe. Default 0.95.
    pub jet_pipe: f64,
}

impl Default for Volumes {
    fn default() -> Self {
        Self {
            hpc_inlet: 0.275,
            combustor: 0.122,
            inter_turbine: 0.237,
            turbine_exit: 0.324,
            bypass: 0.855,
            jet_pipe: 0.95,
        }
    }
}

/// Cross-section over length of the ducts, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ducts {
    /// Between the compressors. Default 0.0689.
    pub core: f64,
    /// Bypass duct entry. Default 0.0540.
    pub bypass_in: f64,
    /// Low-pressure turbine exit to mixing plane. Default 0.0590.
    pub turbine_exit: f64,
    /// Bypass duct exit to mixing plane. Default 0.0770.
    pub bypass_out: f64,
}

impl Default for Ducts {
    fn default() -> Self {
        Self { core: 0.0689, bypass_in: 0.0540, turbine_exit: 0.0590, bypass_out: 0.0770 }
    }
}

/// Shape of the low-pressure compressor map: a Moore-Greitzer cubic at each speed.
///
/// With `n` the relative corrected speed: flow `exp(a ln n - c ln² n)`, pressure rise
/// `exp(b ln n - d ln² n)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LpcMap {
    /// `a`. Default 1.5.
    pub flow_exponent: f64,
    /// `c`. Default 0.3.
    pub flow_curvature: f64,
    /// `b`. Default 2.4.
    pub pressure_exponent: f64,
    /// `d`. Default 0.
    pub pressure_curvature: f64,
    /// Relative flow at the peak of the characteristic, which is the surge line. Default 0.85.
    pub peak_flow: f64,
    /// Height of the cubic. Default 0.568.
    pub cubic_height: f64,
    /// Loss of efficiency with the square of speed from `best_speed`. Default 0.25.
    pub efficiency_speed: f64,
    /// Loss of efficiency with the square of flow from the spine. Default 0.55.
    pub efficiency_flow: f64,
    /// Relative speed of best efficiency. Default 1.02.
    pub best_speed: f64,
    /// Relative change of flow per degree of guide vanes. Default -0.010.
    pub vane_flow: f64,
    /// Relative change of pressure rise per degree of guide vanes. Default -0.006.
    pub vane_pressure: f64,
}

impl Default for LpcMap {
    fn default() -> Self {
        Self {
            flow_exponent: 1.5,
            flow_curvature: 0.3,
            pressure_exponent: 2.4,
            pressure_curvature: 0.0,
            peak_flow: 0.85,
            cubic_height: 0.568,
            efficiency_speed: 0.25,
            efficiency_flow: 0.55,
            best_speed: 1.02,
            vane_flow: -0.010,
            vane_pressure: -0.006,
        }
    }
}

/// Shape of the high-pressure compressor map: flow from relative loading `y`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HpcMap {
    /// `a` as in [`LpcMap`]. Default 1.05.
    pub flow_exponent: f64,
    /// `c` as in [`LpcMap`]. Default 4.0.
    pub flow_curvature: f64,
    /// `b` as in [`LpcMap`]. Default 3.20.
    pub pressure_exponent: f64,
    /// `d` as in [`LpcMap`]. Default 0.50.
    pub pressure_curvature: f64,
    /// Relative flow at zero loading. Default 1.03.
    pub choke_flow: f64,
    /// Exponent of the loss of flow with loading. Default 3.
    pub loading_exponent: f64,
    /// Loading at surge. Default 1.30.
    pub surge_loading: f64,
    /// Loss of efficiency with the square of speed from `best_speed`. Default 0.55.
    pub efficiency_speed: f64,
    /// Loss of efficiency with the square of loading from 1. Default 0.20.
    pub efficiency_loading: f64,
    /// Relative speed of best efficiency. Default 1.0.
    pub best_speed: f64,
}

impl Default for HpcMap {
    fn default() -> Self {
        Self {
            flow_exponent: 1.05,
            flow_curvature: 4.0,
            pressure_exponent: 3.20,
            pressure_curvature: 0.50,
            choke_flow: 1.030,
            loading_exponent: 3.0,
            surge_loading: 1.30,
            efficiency_speed: 0.55,
            efficiency_loading: 0.20,
            best_speed: 1.0,
        }
    }
}

/// Shape of a turbine map: an ellipse of flow over pressure ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TurbineMap {
    /// Pressure ratio (exit over inlet) below which the turbine is choked.
    pub critical_ratio: f64,
    /// Loss of efficiency with the square of the departure of `N / √T` from its reference.
    pub efficiency_curvature: f64,
}
