//! Right-hand side of the seventeen differential equations.

use fd_core::Scalar;

use super::{
    auxiliary::Auxiliary,
    combustor::{Combustor, fuel_air_ratio},
    design::Design,
    environment::{Environment, Inlet},
    gas::{Gas, k},
    health::Health,
    hpc::{Hpc, HpcExit},
    lpc::{Lpc, LpcExit},
    nozzle::{Jet, Nozzle},
    params::Parameters,
    plenum::{Duct, Plenum},
    state::{NX, State},
    turbine::{Turbine, TurbineInlet},
};
use crate::error::EngineError;

/// The engine at one flight condition and one state of health: constants in the scalar `T`.
///
/// A value without memory; the caller owns the states.
///
/// ```
/// use fd_jetengine::engine17::{Engine17, Parameters};
///
/// let parameters = Parameters::default();
/// let engine = Engine17::<f64>::new(&parameters)?;
/// let x = parameters.design()?.reference.to_array();
/// let rates = engine.rhs(&x, parameters.reference.fuel);
/// let largest = rates.iter().zip(&x).map(|(dx, x)| (dx / x).abs()).fold(0.0, f64::max);
/// assert!(largest < 1e-5); // per second
/// # Ok::<(), fd_jetengine::EngineError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Engine17<T: Scalar = f64> {
    air: Gas<T>,
    inlet: Inlet<T>,
    lpc: Lpc<T>,
    hpc: Hpc<T>,
    combustor: Combustor<T>,
    hpt: Turbine<T>,
    lpt: Turbine<T>,
    nozzle: Nozzle<T>,
    plenums: Plenums<T>,
    ducts: DuctSet<T>,
    shafts: Shafts<T>,
    /// Cooling, overboard and handling bleed as fractions of the compressor flow.
    cooling: T,
    overboard: T,
    nozzle_setting: T,
    health: Health<T>,
    design: Design,
    parameters: Parameters,
    environment: Environment,
}

#[derive(Clone, Copy, Debug)]
struct Plenums<T> {
    hpc_inlet: Plenum<T>,
    combustor: Plenum<T>,
    inter_turbine: Plenum<T>,
    turbine_exit: Plenum<T>,
    bypass: Plenum<T>,
    jet_pipe: Plenum<T>,
}

#[derive(Clone, Copy, Debug)]
struct DuctSet<T> {
    core: Duct<T>,
    bypass_in: Duct<T>,
    turbine_exit: Duct<T>,
    bypass_out: Duct<T>,
}

#[derive(Clone, Copy, Debug)]
struct Shafts<T> {
    /// `J (π / 30)²`, so that power over this and rpm is rpm/s.
    inertia_l: T,
    inertia_h: T,
    mechanical_efficiency: T,
    /// Accessory power per rpm, W.
    accessories: T,
}

impl<T: Scalar> Engine17<T> {
    /// A healthy engine at sea level, static, standard day.
    ///
    /// # Errors
    ///
    /// Returns an error when the reference point is not that of an engine; see
    /// [`Parameters::design`].
    pub fn new(parameters: &Parameters) -> Result<Self, EngineError> {
        let (p, d) = (parameters, parameters.design()?);
        let environment = Environment::default();
        let (v, a) = (&p.volumes, &p.ducts);
        let rpm = (std::f64::consts::PI / 30.0).powi(2);
        Ok(Self {
            air: Gas::air(),
            inlet: Inlet::new(&environment, p.ram_recovery),
            lpc: Lpc::new(p, &d, &environment),
            hpc: Hpc::new(p, &d),
            combustor: Combustor::new(p, &d),
            hpt: Turbine::new(p.hpt, d.hpt_flow, d.hpt_efficiency, d.hpt_speed),
            lpt: Turbine::new(p.lpt, d.lpt_flow, d.lpt_efficiency, d.lpt_speed),
            nozzle: Nozzle::new(d.nozzle_area, p.jet_pipe_area),
            plenums: Plenums {
                hpc_inlet: Plenum::new(v.hpc_inlet),
                combustor: Plenum::new(v.combustor),
                inter_turbine: Plenum::new(v.inter_turbine),
                turbine_exit: Plenum::new(v.turbine_exit),
                bypass: Plenum::new(v.bypass),
                jet_pipe: Plenum::new(v.jet_pipe),
            },
            ducts: DuctSet {
                core: Duct::new(a.core, 0.0),
                bypass_in: Duct::new(a.bypass_in, d.k_b),
                turbine_exit: Duct::new(a.turbine_exit, d.k_6),
                bypass_out: Duct::new(a.bypass_out, d.k_29),
            },
            shafts: Shafts {
                inertia_l: k(p.inertia_l * rpm),
                inertia_h: k(p.inertia_h * rpm),
                mechanical_efficiency: k(p.mechanical_efficiency),
                accessories: k(p.accessory_power / p.reference.n_h),
            },
            cooling: k(p.cooling),
            overboard: k(p.overboard_bleed),
            nozzle_setting: k(environment.nozzle_area),
            health: Health::default(),
            design: d,
            parameters: p.clone(),
            environment,
        })
    }

    /// The same engine elsewhere.
    #[must_use]
    pub fn at(mut self, environment: Environment) -> Self {
        let p = &self.parameters;
        self.inlet = Inlet::new(&environment, p.ram_recovery);
        self.lpc = Lpc::new(p, &self.design, &environment);
        self.overboard = k(p.overboard_bleed + environment.handling_bleed);
        self.nozzle_setting = k(environment.nozzle_area);
        self.environment = environment;
        self
    }

    /// The same engine in another state of health.
    #[must_use]
    pub fn with_health(mut self, health: Health<T>) -> Self {
        self.health = health;
        self
    }

    /// Changes the state of health, for instance from sample to sample.
    pub fn set_health(&mut self, health: Health<T>) {
        self.health = health;
    }

    /// State of health.
    #[must_use]
    pub fn health(&self) -> &Health<T> {
        &self.health
    }

    /// Flight condition and settings.
    #[must_use]
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Parameters the engine was built from.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Derived constants.
    #[must_use]
    pub fn design(&self) -> &Design {
        &self.design
    }

    /// Rates of the states, per second, at a fuel flow in kg/s.
    ///
    /// Never fails; outside of the model's validity (see the module) the numbers mean nothing
    /// and may be NaN.
    pub fn rhs(&self, x: &[T; NX], fuel: T) -> [T; NX] {
        self.rates(x, fuel).0
    }

    /// Rates of the states, and what else is known at that instant.
    pub fn rates(&self, x: &[T; NX], fuel: T) -> ([T; NX], Auxiliary<T>) {
        self.rates_with_heat(x, fuel, [T::zero(); 2])
    }

    /// As [`Engine17::rates`], with heat in W from the metal into the gas at the inlets of the
    /// high- and low-pressure turbines.
    pub fn rates_with_heat(
        &self,
        x: &[T; NX],
        fuel: T,
        [heat_4, heat_5]: [T; 2],
    ) -> ([T; NX], Auxiliary<T>) {
        let s = State::from_array(x);
        let (health, air, zero) = (&self.health, &self.air, T::zero());

        let lpc = self.lpc.run(air, &self.inlet, health, s.n_l, s.w_2 + s.w_b);
        let hpc = self.hpc.run(air, health, s.n_h, s.p_2, s.p_3, lpc.t_2, lpc.h_2);

        // Bleeds and combustor.
        let w_cool = hpc.w_3 * self.cooling * health.cooling_flow;
        let w_a = hpc.w_3 - w_cool - hpc.w_3 * (self.overboard + health.bleed_leak);
        let f_4 = fuel_air_ratio(fuel, w_a, 0.1);
        let gas_4 = Gas::products(f_4);
        let p_4 = self.combustor.exit_pressure(w_a, s.p_3, hpc.t_3);

        // Turbines.
        let h_4 = gas_4.enthalpy(s.t_4);
        let inlet = TurbineInlet { gas: &gas_4, p: p_4, t: s.t_4, h: h_4 };
        let hpt = self.hpt.run(&inlet, s.n_h, s.p_5, health.hpt_flow, health.hpt_efficiency);
        let gas_5 = Gas::products(fuel_air_ratio(fuel, w_a + w_cool, 0.1));
        let h_5 = gas_5.enthalpy(s.t_5);
        let inlet = TurbineInlet { gas: &gas_5, p: s.p_5, t: s.t_5, h: h_5 };
        let lpt = self.lpt.run(&inlet, s.n_l, s.p_6, health.lpt_flow, health.lpt_efficiency);

        // Shafts.
        let shafts = &self.shafts;
        let power_lpc = s.w_2 * (lpc.h_2 - self.inlet.h_1) + s.w_b * (lpc.h_b - self.inlet.h_1);
        let excess_l = lpt.w * (h_5 - lpt.h) - power_lpc / shafts.mechanical_efficiency;
        let excess_h = hpt.w * (h_4 - hpt.h)
            - hpc.w_3 * (hpc.h_3 - lpc.h_2) / shafts.mechanical_efficiency
            - shafts.accessories * s.n_h;

        // Jet pipe.
        let gas_7 = Gas::products(fuel_air_ratio(fuel, s.w_6 + s.w_29 - fuel, 0.5));
        let pa = self.inlet.p_ambient;
        let area = self.nozzle_setting * health.nozzle_area;
        let jet = self.nozzle.run(s.ps_7, s.t_7, gas_7.cp(s.t_7), pa, area);

        // Storage.
        let (v, d) = (&self.plenums, &self.ducts);
        let burn = (fuel, self.combustor.fuel_heat(health));
        let v_3 = v.combustor.rates(&gas_4, s.p_3, s.t_4, [(w_a, hpc.h_3), burn], hpt.w, heat_4);
        let v_5 = v.inter_turbine.rates(
            &gas_5,
            s.p_5,
            s.t_5,
            [(hpt.w, hpt.h), (w_cool, hpc.h_3)],
            lpt.w,
            heat_5,
        );
        let v_6 = v.turbine_exit.rates(&gas_5, s.p_6, s.t_6, [(lpt.w, lpt.h)], s.w_6, zero);
        let v_29 = v.bypass.rates(air, s.p_29, s.t_29, [(s.w_b, lpc.h_b)], s.w_29, zero);
        let mixed = [(s.w_6, gas_5.enthalpy(s.t_6)), (s.w_29, air.enthalpy(s.t_29))];
        let v_7 = v.jet_pipe.rates(&gas_7, s.ps_7, s.t_7, mixed, jet.w_8, zero);

        let rates = State {
            n_l: excess_l / (shafts.inertia_l * s.n_l),
            n_h: excess_h / (shafts.inertia_h * s.n_h),
            w_2: d.core.flow_rate(lpc.p_13, s.p_2, s.w_2, lpc.t_2),
            p_2: v.hpc_inlet.pressure_rate(lpc.t_2, s.w_2, hpc.w_3),
            p_3: v_3.p,
            t_4: v_3.t,
            p_5: v_5.p,
            t_5: v_5.t,
            p_6: v_6.p,
            t_6: v_6.t,
            w_6: d.turbine_exit.flow_rate(s.p_6, s.ps_7, s.w_6, s.t_6),
            w_b: d.bypass_in.flow_rate(lpc.p_b, s.p_29, s.w_b, lpc.t_b),
            p_29: v_29.p,
            t_29: v_29.t,
            w_29: d.bypass_out.flow_rate(s.p_29, s.ps_7, s.w_29, s.t_29),
            ps_7: v_7.p,
            t_7: v_7.t,
        };
        let powers = [excess_l, excess_h];
        let auxiliary = self.auxiliary(&s, &lpc, &hpc, &jet, f_4, [hpt.w, lpt.w], powers);
        (rates.to_array(), auxiliary)
    }

    #[allow(clippy::too_many_arguments, reason = "collects the components' results")]
    fn auxiliary(
        &self,
        s: &State<T>,
        lpc: &LpcExit<T>,
        hpc: &HpcExit<T>,
        jet: &Jet<T>,
        fuel_air_ratio: T,
        [w_4, w_5]: [T; 2],
        [excess_power_l, excess_power_h]: [T; 2],
    ) -> Auxiliary<T> {
        Auxiliary {
            pi_lpc: lpc.pi,
            pi_hpc: hpc.pi,
            lpc_efficiency: lpc.efficiency,
            hpc_efficiency: hpc.efficiency,
            t_2: lpc.t_2,
            t_3: hpc.t_3,
            w_3: hpc.w_3,
            w_4,
            w_5,
            w_8: jet.w_8,
            thrust: jet.thrust - (s.w_2 + s.w_b) * self.inlet.speed,
            overall_pressure_ratio: s.p_3 / self.inlet.p_1,
            bypass_ratio: s.w_b / s.w_2,
            nozzle_pressure_ratio: jet.pt_7 / self.inlet.p_ambient,
            pt_7: jet.pt_7,
            fuel_air_ratio,
            lpc_relative_flow: lpc.x,
            hpc_loading: hpc.y,
            hpc_surge_margin: k::<T>(self.parameters.hpc.surge_loading) / hpc.y - T::one(),
            excess_power_l,
            excess_power_h,
        }
    }
}
