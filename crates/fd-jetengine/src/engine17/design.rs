//! Closed-form evaluation of the constants that make the reference point an equilibrium.

use super::{
    compressor::Compression, environment::Environment, gas::Gas, nozzle::Nozzle,
    params::Parameters, state::State, turbine::ellipse,
};
use crate::error::EngineError;

/// Constants derived from [`Parameters`], in the order in which they are evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Design {
    /// Inlet total temperature, K.
    pub t_1: f64,
    /// Inlet total pressure, kPa.
    pub p_1: f64,
    /// Pressure ratio of the low-pressure compressor, core stream.
    pub pi_lpc: f64,
    /// Low-pressure compressor delivery temperature, K.
    pub t_2: f64,
    /// Pressure ratio of the high-pressure compressor.
    pub pi_hpc: f64,
    /// Corrected flow of the low-pressure compressor, kg/s.
    pub lpc_corrected_flow: f64,
    /// Corrected low-pressure speed, rpm.
    pub lpc_corrected_speed: f64,
    /// Corrected flow of the high-pressure compressor, kg/s.
    pub hpc_corrected_flow: f64,
    /// Corrected high-pressure speed, rpm.
    pub hpc_corrected_speed: f64,
    /// High-pressure turbine efficiency, from the power balance of its shaft.
    pub hpt_efficiency: f64,
    /// Low-pressure turbine efficiency, from the power balance of its shaft.
    pub lpt_efficiency: f64,
    /// `k_b` of the combustor loss `k_b W_a² T_3 / P_3²`.
    pub combustor_loss: f64,
    /// Flow constant of the high-pressure turbine.
    pub hpt_flow: f64,
    /// Flow constant of the low-pressure turbine.
    pub lpt_flow: f64,
    /// `N_H / √T_4` at the reference point.
    pub hpt_speed: f64,
    /// `N_L / √T_5` at the reference point.
    pub lpt_speed: f64,
    /// Loss constant of the turbine exit duct.
    pub k_6: f64,
    /// Loss constant of the bypass entry.
    pub k_b: f64,
    /// Loss constant of the bypass exit.
    pub k_29: f64,
    /// Nozzle throat area, m².
    pub nozzle_area: f64,
    /// Shut-off value of the low-pressure compressor cubic.
    pub psi_0: f64,
    /// The reference point.
    pub reference: State,
}

impl Parameters {
    /// Evaluates the derived constants.
    ///
    /// # Errors
    ///
    /// Returns an error naming the first derived constant that is not a positive number, or a
    /// turbine efficiency above 1: the reference point is then not that of an engine.
    pub fn design(&self) -> Result<Design, EngineError> {
        let r = &self.reference;
        let air = Gas::<f64>::air();
        let ambient = Environment::default().ambient();
        let (t_1, p_1) = (ambient.total_temperature, ambient.total_pressure * self.ram_recovery);
        let h_1 = air.enthalpy(t_1);

        // Compressors. Initial guesses of Newton's method are those of the running model.
        let pi_lpc = r.p_2 / p_1;
        let pi_outer = 1.0 + (pi_lpc - 1.0) * self.outer_stream;
        let efficiency = self.lpc_efficiency;
        let core = Compression::new(&air, t_1, h_1, pi_lpc, efficiency);
        let bypass = Compression::new(&air, t_1, h_1, pi_outer, efficiency);
        let (t_2, h_2, t_b, h_b) = (core.t, core.h, bypass.t, bypass.h);
        let p_b = p_1 * pi_outer;
        let pi_hpc = r.p_3 / r.p_2;
        let delivery = Compression::new(&air, t_2, h_2, pi_hpc, self.hpc_efficiency);
        let (t_3, h_3) = (delivery.t, delivery.h);

        // Combustor.
        let w_3 = r.w_2;
        let w_cool = w_3 * self.cooling;
        let w_a = w_3 - w_cool - w_3 * self.overboard_bleed;
        let w_4 = w_a + r.fuel;
        let gas_4 = Gas::products(r.fuel / w_a);
        let heat = self.combustor_efficiency * self.heating_value + self.fuel_enthalpy;
        let h_4 = (w_a * h_3 + r.fuel * heat) / w_4;
        let t_4 = gas_4.temperature_of_enthalpy(h_4, 1250.0);
        let p_4 = r.p_3 * (1.0 - self.combustor_loss);

        // High-pressure turbine: its efficiency follows from the power balance of the shaft.
        let power_h = w_3 * (h_3 - h_2) / self.mechanical_efficiency + self.accessory_power;
        let h_45 = h_4 - power_h / w_4;
        let ideal = gas_4.isentropic(t_4, r.p_5 / p_4);
        let hpt_efficiency = (h_4 - h_45) / (h_4 - gas_4.enthalpy(ideal));

        // Low-pressure turbine, likewise.
        let w_5 = w_4 + w_cool;
        let gas_5 = Gas::products(r.fuel / (w_a + w_cool));
        let h_5 = (w_4 * h_45 + w_cool * h_3) / w_5;
        let t_5 = gas_5.temperature_of_enthalpy(h_5, 950.0);
        let power_l = (r.w_2 * (h_2 - h_1) + r.w_b * (h_b - h_1)) / self.mechanical_efficiency;
        let h_6 = h_5 - power_l / w_5;
        let ideal = gas_5.isentropic(t_5, r.p_6 / r.p_5);
        let lpt_efficiency = (h_5 - h_6) / (h_5 - gas_5.enthalpy(ideal));
        let t_6 = gas_5.temperature_of_enthalpy(h_6, 820.0);

        // Mixing and nozzle.
        let w_7 = w_5 + r.w_b;
        let gas_7 = Gas::products(r.fuel / (w_7 - r.fuel));
        let h_7 = (w_5 * h_6 + r.w_b * h_b) / w_7;
        let t_7 = gas_7.temperature_of_enthalpy(h_7, 660.0);
        let nozzle_area = Nozzle::area_for(
            w_7,
            r.ps_7,
            t_7,
            gas_7.gamma(t_7),
            ambient.pressure,
            self.jet_pipe_area,
        );

        let surge_side = 2.0 / self.lpc.peak_flow - 1.0;
        let psi_0 =
            1.0 - self.lpc.cubic_height * (1.0 + 1.5 * surge_side - 0.5 * surge_side.powi(3));
        let root_theta = (t_1 / 288.15).sqrt();
        let root_theta_2 = (t_2 / 288.15).sqrt();
        let design = Design {
            t_1,
            p_1,
            pi_lpc,
            t_2,
            pi_hpc,
            lpc_corrected_flow: (r.w_2 + r.w_b) * root_theta / (p_1 / 101.325),
            lpc_corrected_speed: r.n_l / root_theta,
            hpc_corrected_flow: w_3 * root_theta_2 / (r.p_2 / 101.325),
            hpc_corrected_speed: r.n_h / root_theta_2,
            hpt_efficiency,
            lpt_efficiency,
            combustor_loss: self.combustor_loss / (w_a * w_a * t_3 / (r.p_3 * r.p_3)),
            hpt_flow: w_4 * t_4.sqrt() / p_4 / ellipse(r.p_5 / p_4, self.hpt.critical_ratio),
            lpt_flow: w_5 * t_5.sqrt() / r.p_5 / ellipse(r.p_6 / r.p_5, self.lpt.critical_ratio),
            hpt_speed: r.n_h / t_4.sqrt(),
            lpt_speed: r.n_l / t_5.sqrt(),
            k_6: (r.p_6 - r.ps_7) * r.p_6 / (w_5 * w_5 * t_6),
            k_b: (p_b - r.p_29) * p_b / (r.w_b * r.w_b * t_b),
            k_29: (r.p_29 - r.ps_7) * r.p_29 / (r.w_b * r.w_b * t_b),
            nozzle_area,
            psi_0,
            reference: State {
                n_l: r.n_l,
                n_h: r.n_h,
                w_2: r.w_2,
                p_2: r.p_2,
                p_3: r.p_3,
                t_4,
                p_5: r.p_5,
                t_5,
                p_6: r.p_6,
                t_6,
                w_6: w_5,
                w_b: r.w_b,
                p_29: r.p_29,
                t_29: t_b,
                w_29: r.w_b,
                ps_7: r.ps_7,
                t_7,
            },
        };
        design.check()?;
        Ok(design)
    }
}

impl Design {
    /// Refuses a reference point that no engine can have.
    fn check(&self) -> Result<(), EngineError> {
        let positive = [
            ("LPC pressure ratio - 1", self.pi_lpc - 1.0),
            ("HPC pressure ratio - 1", self.pi_hpc - 1.0),
            ("LPC corrected flow", self.lpc_corrected_flow),
            ("LPC corrected speed", self.lpc_corrected_speed),
            ("HPC corrected flow", self.hpc_corrected_flow),
            ("HPC corrected speed", self.hpc_corrected_speed),
            ("HPT efficiency", self.hpt_efficiency),
            ("LPT efficiency", self.lpt_efficiency),
            ("1 - HPT efficiency", 1.0 - self.hpt_efficiency),
            ("1 - LPT efficiency", 1.0 - self.lpt_efficiency),
            ("combustor loss constant", self.combustor_loss),
            ("HPT flow constant", self.hpt_flow),
            ("LPT flow constant", self.lpt_flow),
            ("duct loss k6", self.k_6),
            ("duct loss kB", self.k_b),
            ("duct loss k29", self.k_29),
            ("nozzle area", self.nozzle_area),
        ];
        for (quantity, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(EngineError::Design { quantity, value });
            }
        }
        for (index, value) in self.reference.to_array().into_iter().enumerate() {
            if !(value > 0.0 && value.is_finite()) {
                return Err(EngineError::NonFinite { index, value, time: 0.0 });
            }
        }
        Ok(())
    }
}
