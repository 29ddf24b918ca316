//! A driven pendulum as a black box, and the real one with something that the black box lacks.

use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering},
};

use fd_model::{Channel, Record, SampleTime, signal::WhiteNoise};
use fd_sim::{
    model::Parameter,
    simulate::{Initial, NativeEffect, Port, Shell, Simulator},
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

pub(crate) const TS: f64 = 0.02;
/// Noise of angle and rate.
pub(crate) const NOISE: [f64; 2] = [0.002, 0.01];
/// Inertia, stiffness of gravity and damping.
pub(crate) const THETA: [f64; 3] = [0.05, 1.2, 0.12];

/// `J q'' = u + f - G sin(q) - d q'`, by Runge-Kutta of order 4 with fixed steps.
#[derive(Clone, Debug)]
pub(crate) struct Pendulum {
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
    parameters: Vec<Parameter>,
    natives: Vec<NativeEffect>,
    initial: Vec<Initial>,
    ports: Vec<Port>,
    pub(crate) ts: f64,
    theta: [f64; 3],
    /// Dry friction, more inertia and more damping, all of its own.
    own: [f64; 3],
    x: [f64; 2],
    /// Whether outputs can be had without a step.
    measures: bool,
    /// Below this inertia it does not run, and how often that was tried.
    least_inertia: f64,
    refused: Arc<AtomicUsize>,
    /// Whether its states can be seen.
    shows: bool,
    /// Largest torque of its motor.
    strongest: f64,
    /// Steps of this and all its copies.
    steps: Arc<AtomicUsize>,
}

impl Pendulum {
    pub(crate) fn new(ts: f64) -> Self {
        let names = [("J", "kg m^2"), ("G", "N m"), ("d", "N m s")];
        let parameter = |((name, unit), value): ((&str, &str), f64)| Parameter {
            tolerance: 0.03,
            bounds: Some([1e-3, 10.0]),
            ..Parameter::new(name, unit, value)
        };
        let initial = |name: &str, unit: &str| Initial {
            channel: Channel::new(name, unit),
            value: 0.0,
            tolerance: Some(0.05),
        };
        Self {
            inputs: vec![Channel::new("motor torque", "N m")],
            outputs: vec![Channel::new("angle", "rad"), Channel::new("rate", "rad/s")],
            parameters: names.into_iter().zip(THETA).map(parameter).collect(),
            natives: Vec::new(),
            initial: vec![initial("q", "rad"), initial("w", "rad/s")],
            ports: vec![Port { channel: Channel::new("pivot", "N m") }],
            ts,
            theta: THETA,
            own: [0.0; 3],
            x: [0.0; 2],
            measures: true,
            least_inertia: f64::NEG_INFINITY,
            refused: Arc::default(),
            shows: true,
            strongest: f64::INFINITY,
            steps: Arc::default(),
        }
    }

    /// The same with friction, a rotor and damping of its own, at rest.
    pub(crate) fn with_natives(mut self) -> Self {
        let native = |label: &str, place: &str, name: &str, unit: &str, size: f64| {
            let parameter =
                Parameter { bounds: Some([0.0, 10.0]), ..Parameter::new(name, unit, 0.0) };
            NativeEffect::new(label, place, parameter, size)
        };
        self.natives = vec![
            native("coulomb-friction", "pivot", "dry", "N m", 0.1),
            native("rotor-inertia", "rotor 1", "rotor", "kg m^2", 0.01),
            native("viscous-friction", "pivot", "damper", "N m s/rad", 0.05),
        ];
        self.parameters.extend(self.natives.iter().map(|native| native.parameter.clone()));
        self
    }

    /// The same with outputs that are rounded to single precision, and no states to be seen.
    pub(crate) fn in_the_dark(mut self) -> Self {
        self.shows = false;
        self
    }

    /// The same with a motor that gives no more than a torque.
    pub(crate) fn with_strongest(mut self, torque: f64) -> Self {
        self.strongest = torque;
        self
    }

    /// Counts the steps of this and all its copies.
    pub(crate) fn steps(&self) -> Arc<AtomicUsize> {
        Arc::clone(&self.steps)
    }

    pub(crate) fn without_measuring(mut self) -> Self {
        self.measures = false;
        self
    }

    /// Lets fits try inertias from -20 % to 220 %, but does not run below `least`; returns how
    /// often that was tried.
    pub(crate) fn loosen(&mut self, least: f64) -> Arc<AtomicUsize> {
        self.parameters[0].tolerance = 0.6;
        self.parameters[0].bounds = Some([-1.0, 1.0]);
        self.least_inertia = least;
        Arc::clone(&self.refused)
    }

    #[expect(clippy::cast_possible_truncation, reason = "rounds to single precision")]
    fn look(&self, y: &mut [f64]) {
        let round = |x: f64| if self.shows { x } else { f64::from(x as f32) };
        y.iter_mut().zip(self.x).for_each(|(y, x)| *y = round(x));
    }
}

impl Simulator for Pendulum {
    fn ts(&self) -> SampleTime {
        SampleTime::new(self.ts).unwrap()
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

    fn natives(&self) -> &[NativeEffect] {
        &self.natives
    }

    fn initial(&self) -> &[Initial] {
        &self.initial
    }

    fn ports(&self) -> &[Port] {
        &self.ports
    }

    fn start(&mut self, theta: &[f64], x0: &[f64], _first: u64) {
        self.theta.copy_from_slice(&theta[..3]);
        self.own[..theta.len() - 3].copy_from_slice(&theta[3..]);
        self.x.copy_from_slice(x0);
        if theta[0] < self.least_inertia {
            self.x = [f64::NAN; 2];
            self.refused.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn step(&mut self, u: &[f64], _u_next: &[f64], f: &[f64], y: &mut [f64]) {
        self.steps.fetch_add(1, Ordering::Relaxed);
        self.look(y);
        let torque = u[0].clamp(-self.strongest, self.strongest) + f.first().unwrap_or(&0.0);
        let ([inertia, gravity, damping], [dry, rotor, damper]) = (self.theta, self.own);
        let pull = |x: [f64; 2]| torque - gravity * x[0].sin() - (damping + damper) * x[1];
        self.x = rubbed(self.x, self.ts, dry, inertia + rotor, pull);
        if self.x.iter().any(|x| x.abs() > 50.0) {
            self.x = [f64::NAN; 2];
        }
    }

    fn measure(&mut self, _u: &[f64], y: &mut [f64]) -> bool {
        if self.measures {
            self.look(y);
        }
        self.measures
    }

    fn state(&self) -> &[f64] {
        if self.shows { &self.x } else { &[0.0; 2] }
    }

    fn precision(&self) -> f64 {
        if self.shows { f64::EPSILON } else { f64::from(f32::EPSILON) }
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }
}

fn runge_kutta(x: [f64; 2], h: f64, rates: impl Fn([f64; 2]) -> [f64; 2]) -> [f64; 2] {
    let ahead = |k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
    let k_1 = rates(x);
    let k_2 = rates(ahead(k_1, 0.5 * h));
    let k_3 = rates(ahead(k_2, 0.5 * h));
    let k_4 = rates(ahead(k_3, h));
    let mean = |i: usize| (k_1[i] + 2.0 * (k_2[i] + k_3[i]) + k_4[i]) / 6.0;
    ahead([mean(0), mean(1)], h)
}

/// A step with dry friction by its events: it slides one way until it stops, and goes on when it is pulled more than it is
/// held.
fn rubbed(x: [f64; 2], h: f64, dry: f64, inertia: f64, pull: impl Fn([f64; 2]) -> f64) -> [f64; 2] {
    let slide = |x: [f64; 2], h: f64, way: f64| {
        runge_kutta(x, h, |x| [x[1], (pull(x) - way * dry) / inertia])
    };
    let from_rest = |x: [f64; 2], h: f64| {
        let torque = pull(x);
        if torque.abs() <= dry { x } else { slide(x, h, torque.signum()) }
    };
    if x[1] == 0.0 {
        return from_rest(x, h);
    }
    let way = x[1].signum();
    let mut end = slide(x, h, way);
    if dry == 0.0 || 0.0 <= end[1] * x[1] {
        return end;
    }
    // The chord of the velocity from the start, to rounding.
    let mut before_stop = h;
    for _ in 0..8 {
        before_stop *= x[1] / (x[1] - end[1]);
        end = slide(x, before_stop, way);
    }
    from_rest([end[0], 0.0], h - before_stop)
}

/// The shell of the pendulum that steps every `ts` seconds.
pub(crate) fn shell(ts: f64) -> Shell {
    shell_of(Pendulum::new(ts))
}

pub(crate) fn shell_of(pendulum: Pendulum) -> Shell {
    let noise = NOISE.map(Some);
    let shell = Shell::new("black-box pendulum", Box::new(pendulum)).unwrap();
    shell.with_noise(&noise).with_motion("pivot", Some("angle"), Some("rate")).unwrap()
}

/// Integration steps of the real pendulum per sample.
pub(crate) const FINE: usize = 40;

/// What the real pendulum has and the black box has not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cause {
    Nothing,
    DeadZone(f64),
    /// In integration steps.
    Delay(usize),
    Lag(f64),
    RateLimit(f64),
    AngleBias(f64),
    Coulomb(f64),
    Inertia(f64),
    /// Of the torque of the motor.
    Limit(f64),
}

/// Steps of random height held for 10 to 40 samples.
pub(crate) fn excitation(samples: usize, amplitude: f64, seed: u64) -> Vec<f64> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut u = Vec::with_capacity(samples + 40);
    while u.len() < samples {
        let level = amplitude * random.random_range(-1.0..1.0);
        u.extend(std::iter::repeat_n(level, random.random_range(10..40_usize)));
    }
    u.truncate(samples);
    u
}

/// A log of the real pendulum, integrated forty times finer, with parameters up to 3 % off, an
/// initial state that nobody knows, and noise.
pub(crate) fn log(cause: Cause, samples: usize, seed: u64) -> Record {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5eed);
    let mut off = |scale: f64| scale * random.random_range(-1.0..1.0);
    let [inertia, gravity, damping] = THETA.map(|value| value * (1.0 + off(0.03)));
    let mut x = [off(0.04), off(0.04)];
    let u = excitation(samples, 0.8, seed);
    let h = TS / FINE as f64;
    let inertia = if let Cause::Inertia(e) = cause { inertia * (1.0 + e) } else { inertia };
    let (mut lagged, mut limited) = (u[0], u[0]);
    let noise: Vec<Vec<f64>> = (0..2)
        .map(|i| WhiteNoise::new(NOISE[i], 2 * seed + i as u64).values(samples).unwrap())
        .collect();
    let mut y = Vec::with_capacity(2 * samples);
    for k in 0..samples {
        let bias = if let Cause::AngleBias(b) = cause { b } else { 0.0 };
        y.extend([x[0] + bias + noise[0][k], x[1] + noise[1][k]]);
        for i in 0..FINE {
            let seen = match cause {
                Cause::DeadZone(w) => u[k] - u[k].clamp(-w, w),
                Cause::Limit(most) => u[k].clamp(-most, most),
                Cause::Delay(late) => u[(k * FINE + i).saturating_sub(late) / FINE],
                Cause::Lag(time) => {
                    let before = lagged;
                    lagged += (u[k] - lagged) * (1.0 - (-h / time).exp());
                    0.5 * (before + lagged)
                }
                Cause::RateLimit(rate) => {
                    let before = limited;
                    limited += (u[k] - limited).clamp(-rate * h, rate * h);
                    0.5 * (before + limited)
                }
                _ => u[k],
            };
            let dry = if let Cause::Coulomb(f) = cause { f } else { 0.0 };
            let pull = |x: [f64; 2]| seen - gravity * x[0].sin() - damping * x[1];
            x = rubbed(x, h, dry, inertia, pull);
        }
    }
    let ts = SampleTime::new(TS).unwrap();
    let pendulum = Pendulum::new(TS);
    assert!(y.iter().all(|y| y.abs() < 20.0), "the pendulum goes round");
    Record::new(pendulum.inputs, pendulum.outputs, u, y, ts).unwrap()
}
