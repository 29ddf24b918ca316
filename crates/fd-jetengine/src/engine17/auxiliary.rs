//! What is known of the gas path besides the states.

/// Quantities of the gas path that are not states, at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Auxiliary<T = f64> {
    /// Pressure ratio of the low-pressure compressor, core stream.
    pub pi_lpc: T,
    /// Pressure ratio of the high-pressure compressor.
    pub pi_hpc: T,
    /// Efficiency of the low-pressure compressor.
    pub lpc_efficiency: T,
    /// Efficiency of the high-pressure compressor.
    pub hpc_efficiency: T,
    /// Temperature at the high-pressure compressor inlet, K.
    pub t_2: T,
    /// Temperature at the high-pressure compressor delivery, K.
    pub t_3: T,
    /// Flow of the high-pressure compressor, kg/s.
    pub w_3: T,
    /// Flow of the high-pressure turbine, kg/s.
    pub w_4: T,
    /// Flow of the low-pressure turbine, kg/s.
    pub w_5: T,
    /// Flow of the nozzle, kg/s.
    pub w_8: T,
    /// Net thrust, N.
    pub thrust: T,
    /// Overall pressure ratio `P_3 / P_1`.
    pub overall_pressure_ratio: T,
    /// Bypass ratio `W_B / W_2`.
    pub bypass_ratio: T,
    /// Nozzle pressure ratio.
    pub nozzle_pressure_ratio: T,
    /// Total pressure of the jet pipe, kPa.
    pub pt_7: T,
    /// Fuel-air ratio of the combustor.
    pub fuel_air_ratio: T,
    /// Relative flow `x` of the low-pressure compressor; it surges below 0.85.
    pub lpc_relative_flow: T,
    /// Relative loading `y` of the high-pressure compressor; it surges above 1.3.
    pub hpc_loading: T,
    /// Surge margin of the high-pressure compressor, `1.3 / y - 1`.
    pub hpc_surge_margin: T,
    /// Power left over on the low-pressure shaft, W; zero in equilibrium.
    pub excess_power_l: T,
    /// Power left over on the high-pressure shaft, W; zero in equilibrium.
    pub excess_power_h: T,
}
