//! The nonlinear engine as a simulator with exposed parameters.

use fd_core::StateVisitor;
use fd_jetengine::{
    EngineError,
    engine17::{
        Dynamics, Engine17, Health, HealthParameter, MEASURED, NX, NY, Parameters, Trim,
        Unmodelled, input_channels, output_channels, state_channels,
    },
};
use fd_model::{Channel, SampleTime};
use fd_sim::{
    model::Parameter,
    simulate::{Initial, Port, Simulator},
};

/// Seventeen states of the engine, then the temperatures of the metal at both turbines.
const STATES: usize = NX + 2;
/// States of the gas that heats the metal: `T_4` and `T_5`.
const HEATING: [usize; 2] = [5, 7];
/// Index of `W_6`.
const W_6: usize = 10;
/// Name of the parameter that says how much heat the metal soaks up: conductance between gas and
/// metal as a multiple of the reference of [`Unmodelled`].
pub const METAL_CONDUCTANCE: &str = "metal_conductance";

/// What is known of the engine that a log comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineKnowledge {
    /// Fuel flow in kg/s at which the engine has settled when a log begins.
    pub fuel: f64,
    /// Time between samples.
    pub ts: SampleTime,
    /// Longest integration step, in s. At the reference point and above, the fastest pole is at
    /// -327 1/s, and Runge-Kutta of order 4 is stable up to 8 ms.
    pub step: f64,
    /// How well efficiencies and flow capacities of the modules are known, as a fraction.
    pub module_tolerance: f64,
    /// How well the heating value of the fuel is known, as a fraction.
    pub fuel_tolerance: f64,
    /// What is measured, as places among `N_L, N_H, T_7, P_6, T_29`.
    pub outputs: Vec<usize>,
}

/// engine17 as a simulator: fuel flow in; `N_L, N_H, T_7, P_6, T_29` or some of them out, in
/// physical units.
///
/// Parameters are the thirteen of [`Health`] and [`METAL_CONDUCTANCE`]. A run starts in the
/// equilibrium that the engine, in the health it has, finds at the fuel flow of the
/// [`EngineKnowledge`]; initial states are relative deviations from it. An engine in surge, or out
/// of the range of its model, is NaN.
///
/// ```
/// use fd_sim::simulate::{Outcome, Simulator};
/// use fd_model::SampleTime;
/// use fdiag::engine_plant::{EngineKnowledge, EngineSimulator};
///
/// let ts = SampleTime::new(0.04)?;
/// let mut engine = EngineSimulator::new(&EngineKnowledge::at(0.712, ts))?;
/// let theta: Vec<f64> = engine.parameters().iter().map(|p| p.value).collect();
/// let mut y = [0.0; 15];
/// let outcome = engine.simulate(&theta, &[0.0; 19], &[0.712, 0.72, 0.72], &mut y);
/// assert_eq!(outcome, Outcome::Complete);
/// // Settled at first, then faster.
/// assert!((y[5] / y[0] - 1.0).abs() < 1e-9 && y[0] + 0.1 < y[10]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct EngineSimulator {
    engine: Engine17<f64>,
    metal: Unmodelled,
    ts: SampleTime,
    fuel: f64,
    steps: u32,
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
    /// States that are measured.
    measured: Vec<usize>,
    parameters: Vec<Parameter>,
    initial: Vec<Initial>,
    /// Equilibrium in the health of this run, and that of the nominal engine.
    settled: Option<Trim>,
    nominal: Trim,
    /// Multiple of the reference conductance.
    conductance: f64,
    x: [f64; STATES],
    /// `x` as relative deviations from the equilibrium.
    deviation: [f64; STATES],
}

impl EngineKnowledge {
    /// The default: integration steps of at most 5 ms, modules known to 0.2 % and fuel to 0.5 %,
    /// all outputs measured.
    #[must_use]
    pub fn at(fuel: f64, ts: SampleTime) -> Self {
        let outputs = (0..NY).collect();
        Self { fuel, ts, step: 5e-3, module_tolerance: 2e-3, fuel_tolerance: 5e-3, outputs }
    }

    /// The parameters of the engine's health, with what is known of them.
    pub(super) fn parameters(&self) -> Vec<Parameter> {
        let health = Health::<f64>::default();
        let each = HealthParameter::ALL.into_iter().map(|parameter| {
            let tolerance = match parameter {
                HealthParameter::HeatingValue => self.fuel_tolerance,
                _ if HealthParameter::MODULES.contains(&parameter) => self.module_tolerance,
                _ => 0.0,
            };
            Parameter { tolerance, ..Parameter::new(parameter.name(), "1", health.get(parameter)) }
        });
        each.collect()
    }

    /// Channels of what is measured.
    pub(super) fn output_channels(&self) -> Vec<Channel> {
        let all = output_channels();
        self.outputs.iter().filter_map(|i| all.get(*i).cloned()).collect()
    }
}

impl EngineSimulator {
    /// The engine that is known so well.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no equilibrium at the fuel flow.
    pub fn new(known: &EngineKnowledge) -> Result<Self, EngineError> {
        let engine = Engine17::new(&Parameters::default())?;
        let nominal = engine.trim(known.fuel)?;
        let mut parameters = known.parameters();
        parameters.push(Parameter::new(METAL_CONDUCTANCE, "1", 0.0));
        let metal = ["HPT metal", "LPT metal"].map(|name| Channel::new(name, "K"));
        let state = |channel: Channel| Initial {
            channel: Channel::new(channel.name, "1"),
            value: 0.0,
            tolerance: None,
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at least 1, and at most the number of steps in a sample"
        )]
        let steps = (known.ts.seconds() / known.step * (1.0 - 1e-9)).ceil().max(1.0) as u32;
        Ok(Self {
            engine,
            metal: Unmodelled::default(),
            ts: known.ts,
            fuel: known.fuel,
            steps,
            inputs: input_channels(),
            outputs: known.output_channels(),
            measured: known.outputs.iter().filter_map(|i| MEASURED.get(*i).copied()).collect(),
            parameters,
            initial: state_channels().into_iter().chain(metal).map(state).collect(),
            settled: Some(nominal.clone()),
            nominal,
            conductance: 0.0,
            x: [f64::NAN; STATES],
            deviation: [f64::NAN; STATES],
        })
    }

    /// The equilibrium of the engine in its present health, with metal as hot as its gas.
    fn equilibrium(trim: &Trim) -> [f64; STATES] {
        let metal = |i: usize| trim.x[HEATING[i - NX]];
        std::array::from_fn(|i| if i < NX { trim.x[i] } else { metal(i) })
    }

    fn rates(&self, x: &[f64; STATES], fuel: f64) -> ([f64; STATES], bool) {
        let mut core = [0.0; NX];
        core.copy_from_slice(&x[..NX]);
        let metal = [
            (self.metal.conductance_h, self.metal.metal_mass_h),
            (self.metal.conductance_l, self.metal.metal_mass_l),
        ];
        let mut heat = [0.0; 2];
        if self.conductance > 0.0 {
            let flow = (x[W_6] / self.engine.design().reference.w_6).max(0.0).powf(0.8);
            heat = std::array::from_fn(|i| {
                self.conductance * metal[i].0 * flow * (x[NX + i] - x[HEATING[i]])
            });
        }
        let (rates, gas_path) = self.engine.rates_with_heat(&core, fuel, heat);
        let is_valid = self.engine.surge_limits().check(&gas_path, 0.0).is_ok();
        let metal = |i: usize| -heat[i] / (metal[i].1 * self.metal.metal_heat);
        (std::array::from_fn(|i| if i < NX { rates[i] } else { metal(i - NX) }), is_valid)
    }

    /// One step of Runge-Kutta of order 4; NaN when the engine is not valid at its start.
    fn integrate(&mut self, fuel: f64, h: f64) {
        let ahead = |x: &[f64; STATES], k: &[f64; STATES], h: f64| -> [f64; STATES] {
            std::array::from_fn(|i| x[i] + h * k[i])
        };
        let (k_1, is_valid) = self.rates(&self.x, fuel);
        if !is_valid || self.x.iter().any(|x| !(x.is_finite() && 0.0 < *x)) {
            self.x = [f64::NAN; STATES];
            return;
        }
        let (k_2, _) = self.rates(&ahead(&self.x, &k_1, 0.5 * h), fuel);
        let (k_3, _) = self.rates(&ahead(&self.x, &k_2, 0.5 * h), fuel);
        let (k_4, _) = self.rates(&ahead(&self.x, &k_3, h), fuel);
        let slope = std::array::from_fn(|i| (k_1[i] + 2.0 * (k_2[i] + k_3[i]) + k_4[i]) / 6.0);
        self.x = ahead(&self.x, &slope, h);
    }

    fn note_deviation(&mut self) {
        let settled = self.settled.as_ref().map_or([f64::NAN; STATES], Self::equilibrium);
        // Metal that takes up no heat is no state of the engine.
        let is_state = |i: usize| i < NX || self.conductance > 0.0;
        self.deviation =
            std::array::from_fn(|i| if is_state(i) { self.x[i] / settled[i] - 1.0 } else { 0.0 });
    }
}

impl Simulator for EngineSimulator {
    fn ts(&self) -> SampleTime {
        self.ts
    }

    fn inputs(&self) -> &[Channel] {
        &self.inputs
    }

    fn outputs(&self) -> &[Channel] {
        &self.outputs
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn initial(&self) -> &[Initial] {
        &self.initial
    }

    fn ports(&self) -> &[Port] {
        &[]
    }

    fn start(&mut self, theta: &[f64], x0: &[f64], _first: u64) {
        let mut health = Health::default();
        for (parameter, value) in HealthParameter::ALL.into_iter().zip(theta) {
            health.set(parameter, *value);
        }
        if self.settled.is_none() || health != *self.engine.health() {
            self.engine.set_health(health);
            self.settled = self.engine.trim_from(self.fuel, &self.nominal.x).ok();
        }
        self.conductance = theta[HealthParameter::ALL.len()];
        let settled = self.settled.as_ref().map_or([f64::NAN; STATES], Self::equilibrium);
        self.x = std::array::from_fn(|i| settled[i] * (1.0 + x0[i]));
        self.note_deviation();
    }

    fn step(&mut self, u: &[f64], _u_next: &[f64], _f: &[f64], y: &mut [f64]) {
        for (y, state) in y.iter_mut().zip(&self.measured) {
            *y = self.x[*state];
        }
        let h = self.ts.seconds() / f64::from(self.steps);
        for _ in 0..self.steps {
            self.integrate(u[0], h);
        }
        self.note_deviation();
    }

    fn measure(&mut self, _u: &[f64], y: &mut [f64]) -> bool {
        for (y, state) in y.iter_mut().zip(&self.measured) {
            *y = self.x[*state];
        }
        true
    }

    fn state(&self) -> &[f64] {
        &self.deviation
    }

    fn visit_memory(&mut self, visitor: &mut dyn StateVisitor<f64>) -> bool {
        // In surge it is NaN. The deviation follows from the state.
        visitor.reals_with_holes("states of the engine", &mut self.x);
        self.note_deviation();
        true
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }
}
