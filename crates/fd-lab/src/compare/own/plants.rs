//! Runs of plants of one's own.

use fd_core::{Limits, Resource};
use fd_model::{
    Channel, Discrete, Record, SampleTime, Scaling, StateSpace,
    fault::{FaultSpec, Site},
    signal::{MultiSine, Phases, SignalSpec, WhiteNoise},
};
use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{
    config::{OwnFault, OwnPlant},
    error::OwnError,
    linear::{linear, unknown},
};
use crate::compare::{
    config::CompareConfig,
    error::CompareError,
    fault::{FaultKind, Sizes},
    plants::{Ask, Plants, Runs},
};

/// Plants of one's own, ready to run.
pub(crate) struct OwnPlants<'a> {
    config: &'a CompareConfig,
    own: &'a OwnPlant,
    kinds: Vec<FaultKind>,
    ts: SampleTime,
    system: StateSpace<Discrete>,
    scaling: Scaling,
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
    /// Where each input of the model, then each output, is found in the plant.
    columns: Vec<Column>,
    plant: Model,
    simulator: EquationSimulator,
    noise: Vec<f64>,
}

/// A signal of a plant by its place.
#[derive(Clone, Copy)]
enum Column {
    Input(usize),
    Output(usize),
}

impl OwnPlant {
    /// Returns the first setting that cannot be, before anything of its size is made.
    fn check(&self, config: &CompareConfig) -> Result<(), OwnError> {
        let wrong = |setting, expected: &str, found: String| {
            Err(OwnError::Setting { setting, expected: expected.to_owned(), found })
        };
        if self.faults.is_empty() {
            return wrong("faults", "at least one", "none".to_owned());
        }
        for OwnFault { sizes, .. } in &self.faults {
            if !sizes.are_possible() {
                return wrong("faults.sizes", Sizes::POSSIBLE, sizes.to_string());
            }
        }
        for (setting, seconds) in
            [("before_s", self.before_s), ("settle_s", config.settle_s.unwrap_or(0.0))]
        {
            if !(seconds >= 0.0 && seconds.is_finite()) {
                return wrong(setting, "finite and not negative", seconds.to_string());
            }
        }
        for (setting, seconds) in [
            ("training.duration_s", config.training.duration_s),
            ("fresh.duration_s", config.duration_s()),
        ] {
            if seconds.is_nan() || seconds < config.sample_time_s {
                return wrong(setting, "at least one sample", seconds.to_string());
            }
            let samples = (self.before_s + seconds) / config.sample_time_s;
            Limits::default().check(Resource::Samples, setting, samples)?;
        }
        Ok(())
    }
}

impl<'a> OwnPlants<'a> {
    pub(crate) fn new(config: &'a CompareConfig, own: &'a OwnPlant) -> Result<Self, OwnError> {
        let ts = SampleTime::new(config.sample_time_s)?;
        own.check(config)?;
        let (model, plant) = (own.model.equations()?, own.plant.equations()?);
        let (system, scaling) = linear(own, &model, ts)?;
        let simulator = EquationSimulator::<f64>::at(&plant, ts)?;
        let (u, y) = (simulator.inputs().to_vec(), Simulator::outputs(&simulator).to_vec());
        let driven: Vec<String> = u.iter().map(|channel| channel.name.clone()).collect();
        unknown("signals", &own.signals, &driven)?;
        for fault in &own.faults {
            let of_sensor = fault.sensor.iter();
            let mut outputs =
                of_sensor.filter(|name| model.outputs.iter().all(|o| o.name != **name));
            if !driven.contains(&fault.input) || own.signals.contains_key(&fault.input) {
                let expected = "an input of the plant without a signal".to_owned();
                let found = fault.input.clone();
                return Err(OwnError::Setting { setting: "faults.input", expected, found });
            }
            if let Some(found) = outputs.next() {
                let (expected, found) = ("an output of the model".to_owned(), found.clone());
                return Err(OwnError::Setting { setting: "faults.sensor", expected, found });
            }
        }
        let nominal = EquationSimulator::<f64>::at(&model, ts)?;
        let (inputs, outputs) = (nominal.inputs().to_vec(), Simulator::outputs(&nominal).to_vec());
        let column = |channel: &Channel| {
            let at = |all: &[Channel]| all.iter().position(|c| c.name == channel.name);
            let here = at(&y).map(Column::Output).or_else(|| at(&u).map(Column::Input));
            here.ok_or_else(|| OwnError::Setting {
                setting: "plant",
                expected: "an input or output for each channel of the model".to_owned(),
                found: channel.name.clone(),
            })
        };
        let columns = inputs.iter().chain(&outputs).map(column).collect::<Result<_, _>>()?;
        let noise = plant.outputs.iter().map(|output| output.noise.unwrap_or(0.0)).collect();
        Ok(Self {
            config,
            own,
            kinds: own.faults.iter().map(kind).collect(),
            ts,
            system,
            scaling,
            inputs,
            outputs,
            columns,
            plant,
            simulator,
            noise,
        })
    }

    /// The parameters of one plant, each anywhere within its tolerance.
    fn parameters(&self, random: &mut Xoshiro256PlusPlus) -> Vec<f64> {
        let mut draw = |value: f64, tolerance: f64| {
            value * (1.0 + tolerance * random.random_range(-1.0..=1.0))
        };
        self.plant.parameters.iter().map(|p| draw(p.value, p.tolerance)).collect()
    }

    /// A run of the plant with these parameters; `seed` draws signals and noise, the same with a fault as without.
    fn run(
        &self,
        theta: &[f64],
        seed: u64,
        samples: usize,
        fault: Option<(&str, FaultSpec)>,
    ) -> Result<Record, OwnError> {
        let mut simulator = self.simulator.clone();
        let before = self.config.samples(self.own.before_s);
        let n = before + samples;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut driven = Vec::new();
        for channel in simulator.inputs() {
            let stream = random.next_u64();
            let values = match self.own.signals.get(&channel.name) {
                Some(signal) => reseeded(signal, stream).values(n, self.ts)?,
                None => vec![0.0; n],
            };
            driven.push(values);
        }
        if let Some((input, fault)) = fault
            && let Some(at) = simulator.inputs().iter().position(|c| c.name == input)
        {
            fault.apply(&mut driven[at][before..], 0.0, self.ts)?;
        }
        let noise =
            self.noise.iter().map(|&sigma| WhiteNoise::new(sigma, random.next_u64()).values(n));
        let noise = noise.collect::<Result<Vec<_>, _>>()?;
        let noise_at = |output: usize, k: usize| noise[output][k];
        let row = |k: usize| driven.iter().map(|values| values[k]).collect::<Vec<f64>>();
        let mut y = vec![0.0; self.noise.len()];
        let (mut us, mut ys) = (Vec::new(), Vec::new());
        let rest: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
        simulator.start(theta, &rest, 0);
        let mut u = row(0);
        for k in 0..n {
            let next = if k + 1 < n { row(k + 1) } else { u.clone() };
            simulator.step(&u, &next, &[], &mut y);
            if y.iter().any(|value| !value.is_finite()) {
                return Err(OwnError::Diverged { seconds: k as f64 * self.ts.seconds() });
            }
            if before <= k {
                let value = |column: &Column| match *column {
                    Column::Input(at) => u[at],
                    Column::Output(at) => y[at] + noise_at(at, k),
                };
                let (inputs, outputs) = self.columns.split_at(self.inputs.len());
                us.extend(inputs.iter().map(value));
                ys.extend(outputs.iter().map(value));
            }
            u = next;
        }
        let record = Record::new(self.inputs.clone(), self.outputs.clone(), us, ys, self.ts)?;
        Ok(record.scaled(&self.scaling)?)
    }

    fn all(&self, ask: Ask) -> Result<Runs, OwnError> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(ask.seed);
        let theta = self.parameters(&mut random);
        let learned = self.config.samples(self.config.training.duration_s);
        let fresh = self.config.samples(self.config.duration_s());
        let training = self.run(&theta, random.next_u64(), learned, None)?;
        let mut seeds = |count: u64| (0..count).map(|_| random.next_u64()).collect::<Vec<_>>();
        let (calibration, healthy) =
            (seeds(self.config.engines.calibration_runs), seeds(ask.fresh_runs));
        let plain = |seeds: &[u64]| -> Result<Vec<Record>, OwnError> {
            seeds.iter().map(|&seed| self.run(&theta, seed, fresh, None)).collect()
        };
        let with_faults = if ask.tested { self.config.engines.fault_runs } else { 0 };
        let one = |(kind, input): (&FaultKind, &str), seed: u64| -> Result<Vec<Record>, OwnError> {
            let faults = &self.config.faults;
            let fault = |size: &f64| faults.spec(kind, *size, self.config.duration_s());
            let faulty = |size| self.run(&theta, seed, fresh, Some((input, fault(size))));
            kind.sizes.iter().map(faulty).collect()
        };
        let faulty = (0..with_faults).zip(&healthy).map(|(_, &seed)| {
            let inputs = self.own.faults.iter().map(|fault| fault.input.as_str());
            self.kinds.iter().zip(inputs).map(|fault| one(fault, seed)).collect()
        });
        Ok(Runs {
            model: self.system.clone(),
            scaling: self.scaling.clone(),
            training,
            calibration: plain(&calibration)?,
            faulty: faulty.collect::<Result<_, _>>()?,
            healthy: plain(&healthy)?,
            // The simulated bias begins after `settle_s` at rest, which the plant is not, and takes its own time to forget that.
            unseen: self.config.fault_start(),
        })
    }
}

impl Plants for OwnPlants<'_> {
    fn kinds(&self) -> &[FaultKind] {
        &self.kinds
    }

    fn outputs(&self) -> Vec<String> {
        self.outputs.iter().map(|channel| channel.name.clone()).collect()
    }

    fn runs(&self, ask: Ask) -> Result<Runs, CompareError> {
        Ok(self.all(ask)?)
    }
}

/// A fault as the comparison counts it.
fn kind(fault: &OwnFault) -> FaultKind {
    FaultKind {
        site: match &fault.sensor {
            Some(sensor) => Site::sensor(sensor.as_str()),
            None => Site::component(fault.input.as_str()),
        },
        profile: fault.profile,
        sizes: fault.sizes.values(),
        unit: Some(fault.unit.clone()),
        called: fault.name.clone(),
    }
}

/// A signal with another draw.
fn reseeded(signal: &SignalSpec, stream: u64) -> SignalSpec {
    let mut drawn = signal.clone();
    match &mut drawn {
        SignalSpec::Prbs(signal) => signal.seed ^= stream,
        SignalSpec::Staircase(signal) => signal.seed ^= stream,
        SignalSpec::WhiteNoise(signal) => signal.seed ^= stream,
        SignalSpec::ArNoise(signal) => signal.seed ^= stream,
        SignalSpec::MultiSine(MultiSine { phases: Phases::Random { seed }, .. }) => *seed ^= stream,
        SignalSpec::Sum { terms } => {
            for term in terms {
                *term = reseeded(term, stream);
            }
        }
        _ => {}
    }
    drawn
}
