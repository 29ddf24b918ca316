//! Our own simulation of a plant with effects: Runge-Kutta of order 4 on a grid that is at least
//! four times finer than that of the diagnosis.

mod inside;

use fd_sim::model::Model;

use super::{
    controller::{Controller, Feedback},
    error::BlindError,
    laws::{Arriving, Measured, Mechanism, Site},
    plants::{Inner, Physics, Plant, inner},
};

/// A plant with what the model file says of it.
pub(super) struct Bench<'a> {
    pub plant: &'a Plant,
    pub model: &'a Model,
    limits: Vec<[f64; 2]>,
    substeps: usize,
    h: f64,
}

/// What a run starts from and sees.
#[derive(Clone, Copy)]
pub(super) struct Trial<'a> {
    pub parameters: &'a [f64],
    /// Initial states of the model.
    pub x0: &'a [f64],
    /// External inputs, row by row.
    pub u: &'a [f64],
    /// Noise of all outputs, row by row; none for a noise-free run.
    pub noise: Option<&'a [f64]>,
    /// What makes commands of references instead of the plant's own controller; the number of the
    /// run.
    pub controller: Option<(&'a Controller, u64)>,
}

/// What a run has given, row by row.
pub(super) struct Trace {
    /// Outputs with noise.
    pub y: Vec<f64>,
    /// The same outputs without it; where noise goes round a loop, it has moved the plant.
    pub clean: Vec<f64>,
    /// Commands at all inputs of the plant.
    pub commands: Vec<f64>,
    /// States of the plant.
    pub states: Vec<f64>,
}

/// A law at work at its place.
pub(super) struct Injected {
    pub index: usize,
    pub partner: usize,
    pub mechanism: Mechanism,
}

/// All that there is at a sample.
pub(super) struct Snapshot<'a> {
    pub u: &'a [f64],
    pub x: &'a [f64],
    pub y: &'a [f64],
    pub sites: &'a [Site<'a>],
    pub inner: &'a [f64],
}

/// Sees every sample.
pub(super) trait Observer {
    fn see(&mut self, now: &Snapshot<'_>);
}

impl<'a> Bench<'a> {
    pub(super) fn new(plant: &'a Plant, model: &'a Model) -> Result<Self, BlindError> {
        let value = |name: &str| model.parameter(name).map(|p| p.value);
        let limits = model.inputs.iter().map(|input| {
            let limit = |i: usize, default: f64| {
                let expr = input.saturation.as_ref().map(|limits| &limits[i]);
                expr.and_then(|expr| expr.evaluate(&value).ok()).unwrap_or(default)
            };
            [limit(0, f64::NEG_INFINITY), limit(1, f64::INFINITY)]
        });
        let limits = limits.collect();
        let ts = model.sample_time;
        let own = fd_sim::simulate::EquationSimulator::<f64>::new(model)?.substeps();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
        let needed = (ts / plant.step).round() as usize;
        // A whole multiple of the steps of the diagnosis, at least four times as fine.
        let substeps = (4 * own).max(needed.div_ceil(own) * own);
        Ok(Self { plant, model, limits, substeps, h: ts / substeps as f64 })
    }

    /// Outputs and commands of all samples; `None` when the simulation diverges.
    pub(super) fn run(
        &'a self,
        trial: &Trial<'a>,
        injected: Vec<Injected>,
        observer: Option<&mut dyn Observer>,
    ) -> Result<Option<Trace>, BlindError> {
        let physics = self.plant.physics(trial.parameters)?;
        let mut run = Run::new(self, physics, trial, injected);
        Ok(run.go(trial, observer))
    }
}

struct Run<'a> {
    bench: &'a Bench<'a>,
    physics: Box<dyn Physics>,
    injected: Vec<Injected>,
    parameters: Vec<f64>,
    x: Vec<f64>,
    /// States of the laws, after those of the plant.
    z: Vec<f64>,
    /// Commands, and what arrives.
    command: Vec<f64>,
    u: Vec<f64>,
    y: Vec<f64>,
    held: Vec<f64>,
    /// Acceleration per force of each site.
    compliance: Vec<f64>,
    memory: Vec<f64>,
    feedback: Option<(Feedback<'a>, &'a Controller)>,
    /// Signals inside, and by how much each is changed during a step.
    inner: &'static [Inner],
    changes: Vec<f64>,
    shows_command: Vec<bool>,
    t: f64,
}

impl<'a> Run<'a> {
    fn new(
        bench: &'a Bench<'a>,
        physics: Box<dyn Physics>,
        trial: &Trial<'a>,
        injected: Vec<Injected>,
    ) -> Self {
        let model = bench.model;
        let (nu, ny) = (model.inputs.len(), model.outputs.len());
        let x = physics.begin(&trial.x0[..model.states.len()]);
        let states = |i: &Injected| match &i.mechanism {
            Mechanism::Force { states, .. } => *states,
            _ => 0,
        };
        let mut probe = [vec![0.0; ny], vec![0.0; ny]];
        physics.outputs(&x, &vec![0.0; nu], &mut probe[0]);
        physics.outputs(&x, &vec![1.0; nu], &mut probe[1]);
        let moved = probe[0].iter().zip(&probe[1]).map(|(a, b)| (a - b).abs() > 0.0);
        Self {
            z: vec![0.0; injected.iter().map(states).sum()],
            command: vec![0.0; nu],
            u: vec![0.0; nu],
            y: vec![0.0; ny],
            held: vec![0.0; model.sites.len()],
            compliance: vec![1.0; model.sites.len()],
            memory: vec![0.0; physics.memory()],
            parameters: trial.parameters.to_vec(),
            feedback: trial
                .controller
                .map(|(controller, run)| (controller.start(model.sample_time, run), controller)),
            inner: inner(bench.plant),
            changes: vec![0.0; inner(bench.plant).len()],
            shows_command: moved.collect(),
            t: 0.0,
            bench,
            physics,
            injected,
            x,
        }
    }

    fn go(
        &mut self,
        trial: &Trial<'_>,
        mut observer: Option<&mut (dyn Observer + '_)>,
    ) -> Option<Trace> {
        let model = self.bench.model;
        let (ny, nr) = (self.y.len(), self.bench.plant.drives.len());
        let rows = trial.u.len() / nr;
        let room = |width: usize| Vec::with_capacity(rows * width);
        let mut all = Trace {
            y: room(ny),
            clean: room(ny),
            commands: room(self.command.len()),
            states: room(self.x.len()),
        };
        let senses = self.injected.iter().any(|i| matches!(i.mechanism, Mechanism::Sensor(_)));
        let sigma: Vec<f64> = model.outputs.iter().map(|o| o.noise.unwrap_or(0.0)).collect();
        for (k, reference) in trial.u.chunks_exact(nr).enumerate() {
            for step in 0..self.bench.substeps {
                self.t = k as f64 * model.sample_time + step as f64 * self.bench.h;
                if step == 0 {
                    let noise = trial.noise.map(|noise| &noise[k * ny..(k + 1) * ny]);
                    let row = self.sample(reference, noise, &sigma);
                    all.y.extend(row);
                    all.clean.extend_from_slice(&self.y);
                    all.commands.extend_from_slice(&self.command);
                    all.states.extend_from_slice(&self.x);
                } else if senses {
                    self.sense(|_| true);
                }
                self.set_parameters();
                self.actuate();
                self.change_inside();
                if step == 0
                    && let Some(observer) = observer.as_deref_mut()
                {
                    self.compliances();
                    let f = vec![0.0; self.held.len()];
                    let sites = self.sites(&self.x, &f);
                    let (u, x, y) = (&self.u[..], &self.x[..], &self.y[..]);
                    let inner = self.inner.iter().map(|i| (i.value)(&self.parameters, x));
                    let inner: Vec<f64> = inner.collect();
                    observer.see(&Snapshot { u, x, y, sites: &sites, inner: &inner });
                }
                self.integrate();
            }
            let is_far = |v: &f64| !v.is_finite() || v.abs() > 1e12;
            if self.x.iter().any(is_far) {
                return None;
            }
        }
        Some(all)
    }

    /// Measures, lets the controller act, and returns what is logged.
    fn sample(&mut self, reference: &[f64], noise: Option<&[f64]>, sigma: &[f64]) -> Vec<f64> {
        let shows = self.shows_command.clone();
        self.sense(|c| !shows[c]);
        let before = self.logged(noise, sigma, |c| !shows[c]);
        if let Some((feedback, controller)) = &mut self.feedback {
            self.command.copy_from_slice(reference);
            let i = controller.input;
            self.command[i] = feedback.act(&before, reference[i]);
        } else {
            let sees_noise = self.bench.plant.noise_in_loop;
            let seen = if sees_noise { before.clone() } else { self.y.clone() };
            self.physics.control(&mut self.memory, &seen, reference, &mut self.command);
        }
        for (command, [low, high]) in self.command.iter_mut().zip(&self.bench.limits) {
            *command = command.clamp(*low, *high);
        }
        self.sense(|c| shows[c]);
        let after = self.logged(noise, sigma, |c| shows[c]);
        let pairs = before.into_iter().zip(after).zip(shows);
        pairs.map(|((before, after), shows)| if shows { after } else { before }).collect()
    }

    /// Outputs as the sensors show them, of some channels; the others stay as they were.
    fn sense(&mut self, wanted: impl Fn(usize) -> bool) {
        let mut raw = self.y.clone();
        self.physics.outputs(&self.x, &self.command, &mut raw);
        for (c, value) in raw.iter().enumerate().filter(|(c, _)| wanted(*c)) {
            self.y[c] = *value;
        }
        let (t, h) = (self.t, self.bench.h);
        for injected in &mut self.injected {
            if let Mechanism::Sensor(law) = &mut injected.mechanism
                && wanted(injected.index)
            {
                let y = self.y[injected.index];
                self.y[injected.index] = law(&Measured { y, all: &raw, t, h });
            }
        }
    }

    /// What is logged of some channels, with noise.
    fn logged(
        &mut self,
        noise: Option<&[f64]>,
        sigma: &[f64],
        wanted: impl Fn(usize) -> bool,
    ) -> Vec<f64> {
        let Some(noise) = noise else { return self.y.clone() };
        let mut logged: Vec<f64> = self.y.iter().zip(noise).map(|(y, n)| y + n).collect();
        for injected in &mut self.injected {
            let c = injected.index;
            if let Mechanism::Corrupt(law) = &mut injected.mechanism
                && wanted(c)
            {
                logged[c] = law(self.y[c], noise[c], sigma[c]);
            }
        }
        logged
    }

    fn set_parameters(&mut self) {
        let mut is_changed = false;
        let mut now = self.parameters.clone();
        for injected in &self.injected {
            if let Mechanism::Factor(law) = &injected.mechanism {
                now[injected.index] *= law(self.t);
                is_changed = true;
            }
        }
        if is_changed {
            self.physics.set(&now);
        }
    }

    /// Changes of the signals inside, constant during a step.
    fn change_inside(&mut self) {
        let h = self.bench.h;
        self.changes.fill(0.0);
        for injected in &mut self.injected {
            if let Mechanism::Inside(law) = &mut injected.mechanism {
                let i = injected.index;
                let value = (self.inner[i].value)(&self.parameters, &self.x);
                self.changes[i] += law(value, h) - value;
            }
        }
    }

    fn actuate(&mut self) {
        self.u.copy_from_slice(&self.command);
        let (t, h) = (self.t, self.bench.h);
        for injected in &mut self.injected {
            if let Mechanism::Input(law) = &mut injected.mechanism {
                let u = self.u[injected.index];
                self.u[injected.index] = law(&Arriving { u, all: &self.command, t, h });
            }
        }
    }
}
