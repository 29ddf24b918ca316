//! Sizes of all signals in a simulation of the nominal model.

mod force;
mod motion;
mod parts;
mod signal;

use fd_model::SampleTime;

pub use self::{force::ForceScale, signal::SignalScale};
use self::{force::is_discrete, motion::SiteProbe};
use crate::{
    equation::Expr,
    model::{Draft, Model, Output},
    simulate::{EquationSimulator, SimulateError, Simulator},
};

/// Sizes of all signals in a simulation of the nominal model, from which effects take their units
/// and starts.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayScales {
    /// Time between samples, in seconds.
    pub ts: f64,
    /// Length of the log, in seconds.
    pub duration: f64,
    /// Integration step of the nominal model, in seconds; all candidates use it.
    pub step: f64,
    /// Whether the plant rests where it starts while all inputs are zero, so that they may have been zero before.
    pub rests: bool,
    /// Inputs of the plant as they arrive, those that a controller drives included.
    pub inputs: Vec<SignalScale>,
    /// States of the plant.
    pub states: Vec<SignalScale>,
    /// Outputs.
    pub outputs: Vec<SignalScale>,
    /// Sites of forces.
    pub sites: Vec<ForceScale>,
    /// Signals inside the model that are places for effects, in units that nobody states; none unless
    /// [`with_signals`](Self::with_signals) measured them.
    pub signals: Vec<SignalScale>,
}

impl ReplayScales {
    /// Simulates the nominal model for `samples` samples with inputs `u` (row by row, as
    /// [`Simulator::simulate`] takes them) and measures all signals. Samples after a divergence do
    /// not count.
    ///
    /// ```
    /// # use fd_sim::{scales::ReplayScales, model::Model};
    /// let model: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "slider"
    /// sample_time = 0.01
    /// parameters = { m = { unit = "kg", value = 2.0 } }
    /// inputs = { u = { unit = "N" } }
    /// states = { v = { unit = "m/s", initial = 0.0, derivative = "u/m" } }
    /// outputs = { y = { unit = "m/s", value = "v" } }
    /// sites = { rail = { unit = "N", enters = { v = "1/m" }, velocity = "v" } }
    /// "#.parse()?;
    /// let u: Vec<f64> = (0..100).map(|k| if k < 50 { 3.0 } else { -3.0 }).collect();
    /// let scales = ReplayScales::of(&model, model.sample_time()?, &u, 100)?;
    /// assert_eq!(scales.inputs[0].peak(), 3.0);
    /// assert_eq!(scales.sites[0].mobility, 0.5);
    /// assert!((scales.sites[0].force - 3.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the model cannot be simulated.
    pub fn of(
        model: &Model,
        ts: SampleTime,
        u: &[f64],
        samples: usize,
    ) -> Result<Self, SimulateError> {
        let nominal = EquationSimulator::<f64>::at(model, ts)?;
        let step = ts.seconds() / nominal.substeps() as f64;

        let sites = SiteProbe::of_all(model);
        let mut probe = Probe { draft: model.clone().into_draft(), count: 0 };
        probe.draft.step = Some(step);
        probe.draft.definitions.extend(sites.iter().flat_map(|site| site.helpers.clone()));
        for input in &model.inputs {
            probe.show(&Expr::name(&input.name));
        }
        for state in &model.states {
            probe.show(&Expr::name(&state.name));
        }
        for site in &sites {
            probe.show(&site.acceleration);
            probe.show(&site.compliance);
            for expr in [&site.velocity, &site.position].into_iter().flatten().chain(&site.parts) {
                probe.show(expr);
            }
        }
        let probed = Model::try_from(probe.draft)?;
        let replay = Replay::of(&probed, ts, u, samples)?;
        let mut columns = 0..probed.outputs.len();
        let mut next = |name: &str, unit: &str| replay.scale(columns.next(), name, unit);
        let outputs = model.outputs.iter().map(|o| next(&o.name, &o.unit)).collect();
        let inputs = model.inputs.iter().map(|i| next(&i.name, &i.unit)).collect();
        let states: Vec<_> = model.states.iter().map(|s| next(&s.name, &s.unit)).collect();
        let sites = model.sites.iter().zip(sites).map(|(site, probe)| {
            let acceleration = next("acceleration", "");
            let compliance = next("compliance", "");
            let mut signal = |expr: Option<Expr>| {
                expr.map(|expr| {
                    let scale = next(&expr.to_string(), "");
                    (expr, scale)
                })
            };
            let (velocity, position) = (signal(probe.velocity), signal(probe.position));
            let parts = probe.parts.iter().map(|_| next("part", "").std);
            let largest = parts.fold(acceleration.std, f64::max);
            let moves = acceleration.moves() && compliance.mean.abs() > 0.0;
            ForceScale {
                name: site.name.clone(),
                unit: site.unit.clone(),
                force: if moves { largest / compliance.mean.abs() } else { 0.0 },
                mobility: compliance.mean,
                kick: compliance.peak() * if is_discrete(model, site) { 1.0 } else { step },
                is_discrete: is_discrete(model, site),
                velocity,
                position,
                acceleration: probe.acceleration,
                compliance: probe.compliance,
                helpers: probe.helpers,
                motion: acceleration,
            }
        });
        let sites = sites.collect();
        let duration = samples as f64 * ts.seconds();
        let rests = rests(&nominal, &states);
        let (ts, signals) = (ts.seconds(), Vec::new());
        Ok(Self { ts, duration, step, rests, inputs, states, outputs, sites, signals })
    }
}

impl ReplayScales {
    /// The same with the definitions of the model as places for effects, measured with the inputs of [`of`](Self::of).
    ///
    /// ```
    /// # use fd_sim::{scales::ReplayScales, model::Model};
    /// let model: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "slider"
    /// sample_time = 0.01
    /// definitions = { push = "u*abs(u)" }
    /// inputs = { u = { unit = "N" } }
    /// states = { v = { unit = "m/s", initial = 0.0, derivative = "push - v" } }
    /// outputs = { y = { unit = "m/s", value = "v" } }
    /// "#.parse()?;
    /// let u: Vec<f64> = (0..100).map(|k| if k < 50 { 3.0 } else { -3.0 }).collect();
    /// let scales = ReplayScales::of(&model, model.sample_time()?, &u, 100)?;
    /// let scales = scales.with_signals(&model, model.sample_time()?, &u, 100)?;
    /// assert_eq!((scales.signals[0].name.as_str(), scales.signals[0].peak()), ("push", 9.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the model cannot be simulated.
    pub fn with_signals(
        self,
        model: &Model,
        ts: SampleTime,
        u: &[f64],
        samples: usize,
    ) -> Result<Self, SimulateError> {
        let mut probe = Probe { draft: model.clone().into_draft(), count: 0 };
        model.definitions.iter().for_each(|definition| probe.show(&Expr::name(&definition.name)));
        let replay = Replay::of(&Model::try_from(probe.draft)?, ts, u, samples)?;
        let names = model.definitions.iter().map(|definition| &definition.name);
        let columns = (model.outputs.len()..).zip(names);
        let signals = columns.map(|(column, name)| replay.scale(Some(column), name, "1")).collect();
        Ok(Self { signals, ..self })
    }

    /// The same for an integration step divided into `factor`, where the outputs of candidates
    /// depend on the step by more than the noise. The nominal model is to be simulated with this
    /// [`step`](Self::step) then, too.
    #[must_use]
    pub fn refined(mut self, factor: u32) -> Self {
        let factor = f64::from(factor.max(1));
        self.step /= factor;
        for site in self.sites.iter_mut().filter(|site| !site.is_discrete) {
            site.kick /= factor;
        }
        self
    }
}

/// Part of how much a state moves that is no motion.
pub(crate) const AT_REST: f64 = 1e-6;

/// Whether states stay where they start during a sample in which all inputs are zero.
fn rests(nominal: &EquationSimulator<f64>, states: &[SignalScale]) -> bool {
    let mut simulator = nominal.clone();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let u = vec![0.0; Simulator::inputs(&simulator).len()];
    let mut y = vec![0.0; Simulator::outputs(&simulator).len()];
    simulator.start(&theta, &x0, 0);
    simulator.step(&u, &u, &[], &mut y);
    let moved = simulator.state().iter().zip(&x0).zip(states);
    let mut moved = moved.map(|((x, x0), scale)| (x - x0).abs() <= AT_REST * scale.std);
    !x0.is_empty() && moved.all(|stays| stays)
}

/// A model that shows inner quantities as outputs.
struct Probe {
    draft: Draft,
    count: usize,
}

impl Probe {
    fn show(&mut self, value: &Expr) {
        self.count += 1;
        let name = self.draft.fresh_name(&format!("probe_{}", self.count));
        self.draft.outputs.push(Output::new(name, "1", value.clone()));
    }
}

/// Outputs of a simulation with nominal parameters, row by row.
struct Replay {
    y: Vec<f64>,
    ny: usize,
}

impl Replay {
    fn of(model: &Model, ts: SampleTime, u: &[f64], samples: usize) -> Result<Self, SimulateError> {
        let mut simulator = EquationSimulator::<f64>::at(model, ts)?;
        let ny = model.outputs.len();
        let mut y = vec![0.0; samples * ny];
        Simulator::simulate(&mut simulator, &model.nominal(), &model.initial(), u, &mut y);
        Ok(Self { y, ny })
    }

    /// Size of an output up to a divergence; of none, of nothing.
    fn scale(&self, column: Option<usize>, name: &str, unit: &str) -> SignalScale {
        let column = column.unwrap_or(self.y.len());
        let values = self.y.iter().skip(column).step_by(self.ny.max(1)).copied();
        SignalScale::of(name, unit, values.take_while(|x| x.is_finite()))
    }
}
