//! A robot arm of any number of joints as equations, and logs of one whose fourth joint rubs:
//!
//! ```sh
//! cargo run --release --example robot -- 12 1000 robot
//! fdiag gap --model robot/model.toml --log robot/monday.csv --held-out robot/friday.csv
//! ```
//!
//! A chain that hangs down. Each joint has a motor behind a gear, viscous friction, the weight of all links beyond it,
//! and a torque that the swing of the next link puts on it. Angles and speeds of all joints are measured: with 12
//! joints there are 24 states, 12 inputs, 24 outputs and 60 uncertain parameters.

use std::{
    error::Error,
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Time between samples, s.
const TS: f64 = 0.01;
/// Integration steps of the real arm per sample.
const STEPS: u32 = 50;
/// Standard deviations of angle (rad) and speed (rad/s).
const NOISE: [f64; 2] = [5e-4, 5e-3];
/// Torque of dry friction in the fourth joint, as a part of the peak of what its motor gives.
const RUBS: f64 = 0.1;
/// Speed below which dry friction is not full, rad/s.
const SMALL: f64 = 0.02;
/// Largest input, A.
const PEAK: f64 = 2.0;

/// Parameters of a joint.
#[derive(Clone, Copy)]
struct Joint {
    /// Inertia at the joint, kg m^2.
    inertia: f64,
    /// Viscous friction, N m s.
    friction: f64,
    /// Torque per current, behind the gear, N m/A.
    gear: f64,
    /// Weight of the link times the place of its centre, N m.
    weight: f64,
    /// Torque per square of the speed of the next joint, kg m^2.
    swing: f64,
}

impl Joint {
    /// Joint `i` of `n`: they become lighter towards the hand.
    fn new(i: usize, n: usize) -> Self {
        let size = 1.0 - 0.6 * i as f64 / n as f64;
        Self {
            inertia: 0.4 * size,
            friction: 1.2 * size,
            gear: 1.5 * size,
            weight: 1.6 * size / (n - i) as f64,
            swing: 0.05 * size,
        }
    }

    /// Names, units, values and tolerances.
    fn parameters(&self) -> [(&'static str, &'static str, f64, f64); 5] {
        [
            ("J", "kg m^2", self.inertia, 0.03),
            ("d", "N m s", self.friction, 0.1),
            ("n", "N m/A", self.gear, 0.03),
            ("w", "N m", self.weight, 0.03),
            ("s", "kg m^2", self.swing, 0.1),
        ]
    }
}

fn model(n: usize) -> Result<String, std::fmt::Error> {
    let mut text = format!(
        "version = 1\nkind = \"equations\"\nname = \"robot\"\n\
         description = \"Robot arm of {n} joints that hangs down\"\nsample_time = {TS}\n\n[parameters]\n"
    );
    for i in 1..=n {
        for (name, unit, value, tolerance) in Joint::new(i - 1, n).parameters() {
            writeln!(
                text,
                "{name}{i} = {{ unit = \"{unit}\", value = {value:.6}, tolerance = {tolerance} }}"
            )?;
        }
    }
    text.push_str("\n[inputs]\n");
    for i in 1..=n {
        writeln!(text, "i{i} = {{ unit = \"A\" }}")?;
    }
    text.push_str("\n[states]\n");
    for i in 1..=n {
        writeln!(text, "q{i} = {{ unit = \"rad\", initial = 0.0, derivative = \"v{i}\" }}")?;
        let law = format!("(n{i}*i{i} - d{i}*v{i} - load{i} - swing{i})/J{i}");
        writeln!(text, "v{i} = {{ unit = \"rad/s\", initial = 0.0, derivative = \"{law}\" }}")?;
    }
    text.push_str("\n[outputs]\n");
    let [angle, speed] = NOISE;
    for i in 1..=n {
        writeln!(
            text,
            "angle{i} = {{ unit = \"rad\", value = \"q{i}\", noise = {angle} }}\n\
             speed{i} = {{ unit = \"rad/s\", value = \"v{i}\", noise = {speed} }}"
        )?;
    }
    text.push_str("\n[definitions]\n");
    for i in 1..=n {
        let before = if i == 1 { String::new() } else { format!("a{} + ", i - 1) };
        writeln!(text, "a{i} = \"{before}q{i}\"")?;
        let beyond = if i == n { String::new() } else { format!(" + load{}", i + 1) };
        writeln!(text, "load{i} = \"w{i}*sin(a{i}){beyond}\"")?;
        let swing = if i == n { "0*s".to_owned() } else { format!("sin(q{0})*v{0}^2*s", i + 1) };
        writeln!(text, "swing{i} = \"{swing}{i}\"")?;
    }
    text.push_str("\n[sites]\n");
    for i in 1..=n {
        writeln!(
            text,
            "joint{i} = {{ unit = \"N m\", enters = {{ v{i} = \"1/J{i}\" }}, position = \"q{i}\", velocity = \"v{i}\" }}"
        )?;
    }
    Ok(text)
}

/// The real arm.
struct Arm {
    joints: Vec<Joint>,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl Arm {
    fn new(n: usize) -> Self {
        let joint = |i: usize| {
            let Joint { inertia, friction, gear, weight, swing } = Joint::new(i, n);
            let off = |part: f64| 1.0 + if i.is_multiple_of(2) { part } else { -part };
            Joint {
                inertia: inertia * off(0.01),
                friction: friction * off(-0.03),
                gear,
                weight: weight * off(0.008),
                swing,
            }
        };
        Self { joints: (0..n).map(joint).collect(), q: vec![0.0; n], v: vec![0.0; n] }
    }

    /// A sample, in steps of Euler's semi-implicit method.
    fn sample(&mut self, current: &[f64]) {
        let h = TS / f64::from(STEPS);
        for _ in 0..STEPS {
            let mut angle: f64 = self.q.iter().sum();
            let (mut load, mut swing) = (0.0, 0.0);
            let mut torques = vec![0.0; current.len()];
            for (i, joint) in self.joints.iter().enumerate().rev() {
                load += joint.weight * angle.sin();
                angle -= self.q[i];
                let dry = RUBS * PEAK * joint.gear * (self.v[i] / SMALL).tanh();
                let rubs = if i == 3 { dry } else { 0.0 };
                let viscous = joint.friction * self.v[i];
                torques[i] = joint.gear * current[i] - viscous - load - joint.swing * swing - rubs;
                swing = self.q[i].sin() * self.v[i].powi(2);
            }
            for (i, torque) in torques.iter().enumerate() {
                self.v[i] += h * torque / self.joints[i].inertia;
                self.q[i] += h * self.v[i];
            }
        }
    }
}

/// A log of the real arm, each motor driven by steps of its own.
fn log(n: usize, samples: usize, seed: u64) -> Result<String, std::fmt::Error> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut text = String::from("time [s]");
    (1..=n).try_for_each(|i| write!(text, ",i{i} [A]"))?;
    (1..=n).try_for_each(|i| write!(text, ",angle{i} [rad],speed{i} [rad/s]"))?;
    let (mut arm, mut current) = (Arm::new(n), vec![0.0; n]);
    for k in 0..samples {
        for (i, current) in current.iter_mut().enumerate() {
            if (k + 7 * i).is_multiple_of(40) {
                *current = random.random_range(-PEAK..PEAK);
            }
        }
        write!(text, "\n{:.2}", TS * k as f64)?;
        current.iter().try_for_each(|i| write!(text, ",{i:.6}"))?;
        for (q, v) in arm.q.iter().zip(&arm.v) {
            // Twelve uniform numbers make one that is nearly normal.
            let mut normal = || (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
            write!(text, ",{:.6},{:.6}", q + NOISE[0] * normal(), v + NOISE[1] * normal())?;
        }
        arm.sample(&current);
    }
    text.push('\n');
    Ok(text)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [joints, samples, to] = arguments.as_slice() else {
        return Err("expected: joints, samples, directory".into());
    };
    let (joints, samples): (usize, usize) = (joints.parse()?, samples.parse()?);
    let to: &Path = &PathBuf::from(to);
    fs::create_dir_all(to)?;
    fs::write(to.join("model.toml"), model(joints)?)?;
    fs::write(to.join("monday.csv"), log(joints, samples, 1)?)?;
    fs::write(to.join("friday.csv"), log(joints, samples, 2)?)?;
    Ok(())
}
