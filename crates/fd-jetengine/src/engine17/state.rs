//! The seventeen states, five outputs and their units.

use fd_model::Channel;

/// Number of states of the engine.
pub const NX: usize = 17;

/// Number of measured outputs.
pub const NY: usize = 5;

/// Names and units of the states, in order.
const STATES: [(&str, &str); NX] = [
    ("N_L", "rpm"),
    ("N_H", "rpm"),
    ("W_2", "kg/s"),
    ("P_2", "kPa"),
    ("P_3", "kPa"),
    ("T_4", "K"),
    ("P_5", "kPa"),
    ("T_5", "K"),
    ("P_6", "kPa"),
    ("T_6", "K"),
    ("W_6", "kg/s"),
    ("W_B", "kg/s"),
    ("P_29", "kPa"),
    ("T_29", "K"),
    ("W_29", "kg/s"),
    ("ps_7", "kPa"),
    ("T_7", "K"),
];

/// States that are measured, in the paper's order `N_L, N_H, T_7, P_6, T_29`.
pub const MEASURED: [usize; NY] = [0, 1, 16, 8, 13];

/// The states of the gas path and shafts, or their derivatives per second.
///
/// Pressures are in kPa, flows in kg/s, temperatures in K, speeds in rpm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T = f64> {
    /// Low-pressure shaft speed, rpm.
    pub n_l: T,
    /// High-pressure shaft speed, rpm.
    pub n_h: T,
    /// Core air flow from the low- to the high-pressure compressor, kg/s.
    pub w_2: T,
    /// Pressure at the inlet of the high-pressure compressor, kPa.
    pub p_2: T,
    /// Pressure at the delivery of the high-pressure compressor, kPa.
    pub p_3: T,
    /// Temperature at the exit of the combustor, K.
    pub t_4: T,
    /// Pressure between the turbines, kPa.
    pub p_5: T,
    /// Temperature between the turbines, K.
    pub t_5: T,
    /// Pressure at the exit of the low-pressure turbine, kPa.
    pub p_6: T,
    /// Temperature at the exit of the low-pressure turbine, K.
    pub t_6: T,
    /// Gas flow from the low-pressure turbine to the mixing plane, kg/s.
    pub w_6: T,
    /// Bypass air flow into its duct, kg/s.
    pub w_b: T,
    /// Pressure of the bypass duct, kPa.
    pub p_29: T,
    /// Temperature of the bypass duct, K.
    pub t_29: T,
    /// Bypass air flow into the mixing plane, kg/s.
    pub w_29: T,
    /// Static pressure of the jet pipe, kPa.
    pub ps_7: T,
    /// Temperature of the jet pipe, K.
    pub t_7: T,
}

impl<T: Copy> State<T> {
    /// Reads the states in order.
    ///
    /// ```
    /// use fd_jetengine::engine17::{NX, State};
    ///
    /// let x: [f64; NX] = std::array::from_fn(|i| i as f64);
    /// assert_eq!(State::from_array(&x).t_7, 16.0);
    /// assert_eq!(State::from_array(&x).to_array(), x);
    /// ```
    #[inline]
    #[must_use]
    pub fn from_array(x: &[T; NX]) -> Self {
        let [
            n_l,
            n_h,
            w_2,
            p_2,
            p_3,
            t_4,
            p_5,
            t_5,
            p_6,
            t_6,
            w_6,
            w_b,
            p_29,
            t_29,
            w_29,
            ps_7,
            t_7,
        ] = *x;
        Self {
            n_l,
            n_h,
            w_2,
            p_2,
            p_3,
            t_4,
            p_5,
            t_5,
            p_6,
            t_6,
            w_6,
            w_b,
            p_29,
            t_29,
            w_29,
            ps_7,
            t_7,
        }
    }

    /// Writes the states in order.
    #[inline]
    #[must_use]
    pub fn to_array(self) -> [T; NX] {
        [
            self.n_l, self.n_h, self.w_2, self.p_2, self.p_3, self.t_4, self.p_5, self.t_5,
            self.p_6, self.t_6, self.w_6, self.w_b, self.p_29, self.t_29, self.w_29, self.ps_7,
            self.t_7,
        ]
    }
}

/// Channels of the states.
#[must_use]
pub fn state_channels() -> Vec<Channel> {
    STATES.iter().map(|&(name, unit)| Channel::new(name, unit)).collect()
}

/// Channels of the measured outputs `N_L, N_H, T_7, P_6, T_29`.
#[must_use]
pub fn output_channels() -> Vec<Channel> {
    MEASURED.iter().map(|&i| Channel::new(STATES[i].0, STATES[i].1)).collect()
}

/// Channel of the input, the main fuel flow.
#[must_use]
pub fn input_channels() -> Vec<Channel> {
    vec![Channel::new("W_f", "kg/s")]
}
