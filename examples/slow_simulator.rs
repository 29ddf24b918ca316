//! How long does a diagnosis take when each run of the simulator is dear?
//!
//! A cart on a spring as a simulator that sleeps: `SECONDS` for a run through the fitted log, in its steps or at once.
//! A process sleeps as well as it computes, so the figures hardly depend on what else the machine does.
//!
//! ```sh
//! cargo run --release -p fdiag --example slow_simulator -- 0.1 steps 8
//! ```
//!
//! `steps`: it steps and shows its states. `blind`: it steps and does not. `runs`: it makes whole runs only. The last
//! argument is the number of instances that may run at once; `runs` and `steps` with `lanes` after it are one instance
//! that makes so many runs in one call, in the time of one.
#![allow(clippy::print_stdout, clippy::indexing_slicing, reason = "a program for people")]

use std::{
    error::Error,
    fmt::Write,
    thread,
    time::{Duration, Instant},
};

use fd_gap::diagnose::{Monitor, Stage};
use fd_sim::outside::{
    Entry, Instance, Lane, Lost, OutsideError, OutsideSimulator, Powers, Source, Start, Stated,
};
use fdiag::gap_study::{GapStudy, Request, Subject};

const TS: f64 = 0.02;
const SAMPLES: usize = 900;
/// Samples that are fitted; the rest is held out.
const FITTED: f64 = 0.67 * SAMPLES as f64;
const NOISE: [f64; 2] = [0.002, 0.01];
/// Mass, damping and stiffness.
const THETA: [f64; 3] = [1.2, 1.5, 4.0];
/// Sleeps are no shorter than this, and what is owed is kept.
const SHORTEST: f64 = 0.005;

/// A cart, `m q'' = u + f − c tanh(q'/0.02) − d q' − k q`, by four steps of Euler's semi-implicit method.
#[derive(Clone, Debug)]
struct Cart {
    theta: [f64; 3],
    friction: f64,
    x: [f64; 2],
}

impl Cart {
    fn step(&mut self, force: f64) -> [f64; 2] {
        let ([m, d, k], y) = (self.theta, self.x);
        for _ in 0..4 {
            let [q, v] = &mut self.x;
            let dry = self.friction * (*v / 0.02).tanh();
            *v += 0.25 * TS / m * (force - dry - d * *v - k * *q);
            *q += 0.25 * TS * *v;
        }
        y
    }
}

/// Carts that take their time.
#[derive(Clone, Debug)]
struct Slow {
    carts: Vec<Cart>,
    per_step: f64,
    owed: f64,
    shows: bool,
}

impl Slow {
    fn pay(&mut self, seconds: f64) {
        self.owed += seconds;
        if SHORTEST <= self.owed {
            let begun = Instant::now();
            thread::sleep(Duration::from_secs_f64(self.owed));
            self.owed -= begun.elapsed().as_secs_f64();
        }
    }
}

impl Instance for Slow {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        self.reset_lanes(&[start])
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.measure_lanes(1, u, y)
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        self.step_lanes(1, row, y, x)
    }

    fn rollouts(&mut self, samples: usize, lanes: &mut [Lane<'_>]) -> Result<(), Lost> {
        let starts: Vec<Start<'_>> = lanes.iter().map(|lane| lane.start).collect();
        self.reset_lanes(&starts)?;
        self.pay(self.per_step * samples as f64);
        for (lane, cart) in lanes.iter_mut().zip(&mut self.carts) {
            for (row, y) in lane.rows.chunks_exact(2).zip(lane.y.chunks_exact_mut(2)) {
                y.copy_from_slice(&cart.step(row[0] + row[1]));
            }
        }
        Ok(())
    }

    fn reset_lanes(&mut self, starts: &[Start<'_>]) -> Result<(), Lost> {
        let cart = |start: &Start<'_>| Cart {
            theta: [start.theta[0], start.theta[1], start.theta[2]],
            friction: 0.0,
            x: [start.x0[0], start.x0[1]],
        };
        self.carts = starts.iter().map(cart).collect();
        Ok(())
    }

    fn measure_lanes(&mut self, _: usize, _: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        for (cart, y) in self.carts.iter().zip(y.chunks_exact_mut(2)) {
            y.copy_from_slice(&cart.x);
        }
        Ok(())
    }

    fn step_lanes(
        &mut self,
        _: usize,
        rows: &[f64],
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        self.pay(self.per_step);
        let each = self.carts.iter_mut().zip(rows.chunks_exact(2)).zip(y.chunks_exact_mut(2));
        for (i, ((cart, row), y)) in each.enumerate() {
            y.copy_from_slice(&cart.step(row[0] + row[1]));
            if self.shows {
                x[2 * i..2 * i + 2].copy_from_slice(&cart.x);
            }
        }
        Ok(())
    }
}

impl Source for Slow {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(self.clone()))
    }
}

fn simulator(
    seconds: f64,
    kind: &str,
    [workers, lanes]: [usize; 2],
) -> Result<OutsideSimulator, Box<dyn Error>> {
    let powers = match kind {
        "steps" => Powers { states: true, measure: true, rollout: true, ..Powers::default() },
        "blind" => Powers { measure: true, rollout: true, ..Powers::default() },
        "runs" => Powers { step: false, rollout: true, ..Powers::default() },
        other => return Err(format!("expected `steps`, `blind` or `runs`, found `{other}`").into()),
    };
    let entry = |name: &str, unit: &str| Entry {
        name: name.to_owned(),
        unit: Some(unit.to_owned()),
        ..Entry::default()
    };
    let parameter = |(name, unit, value, tolerance): (&str, &str, f64, f64)| Entry {
        value: Some(value),
        tolerance: Some(tolerance),
        ..entry(name, unit)
    };
    let output = |name, unit, noise| Entry { noise: Some(noise), ..entry(name, unit) };
    let [m, d, k] = THETA;
    let parameters = [("m", "kg", m, 0.03), ("d", "N s/m", d, 0.1), ("k", "N/m", k, 0.03)];
    let [position, velocity] = ["place", "speed"].map(|name| Some(name.to_owned()));
    let stated = Stated {
        name: Some("cart".to_owned()),
        sample_time: Some(TS),
        inputs: vec![entry("force", "N")],
        outputs: vec![output("place", "m", NOISE[0]), output("speed", "m/s", NOISE[1])],
        parameters: parameters.map(parameter).to_vec(),
        states: vec![entry("q", "m"), entry("v", "m/s")],
        ports: vec![Entry { position, velocity, ..entry("rail", "N") }],
        powers: Some(Powers { lanes, ..powers }),
        ..Stated::default()
    };
    let per_step = seconds / FITTED;
    let slow = Slow { carts: Vec::new(), per_step, owed: 0.0, shows: powers.states };
    Ok(OutsideSimulator::new(stated.contract("cart")?, slow, workers)?)
}

/// A log of the real cart, which rubs, driven by steps of random height.
fn log() -> Result<String, std::fmt::Error> {
    // The generator of Drive::random, as a source of numbers between -1 and 1.
    let mut seed = 20_261_123_u64;
    let mut next = || {
        seed = seed * 48_271 % 2_147_483_647;
        2.0 * seed as f64 / 2_147_483_647.0 - 1.0
    };
    let theta = [1.01 * THETA[0], 0.96 * THETA[1], 1.01 * THETA[2]];
    let mut cart = Cart { theta, friction: 0.4, x: [0.0; 2] };
    let (mut force, mut text) = (0.0, String::from("time [s],force [N],place [m],speed [m/s]\n"));
    for k in 0..SAMPLES {
        if k % 40 == 0 {
            force = 3.0 * next();
        }
        // Twelve even numbers make a nearly normal one, of variance four.
        let mut noise = |sigma: f64| 0.5 * sigma * (0..12).map(|_| next()).sum::<f64>();
        let [place, speed] = cart.x;
        let (place, speed) = (place + noise(NOISE[0]), speed + noise(NOISE[1]));
        writeln!(text, "{},{force},{place},{speed}", TS * k as f64)?;
        cart.step(force);
    }
    Ok(text)
}

/// Says what is planned, and when what begins, and how many runs' worth of steps were made before.
struct Said<'a> {
    begun: Instant,
    subject: &'a Subject,
}

impl Monitor for Said<'_> {
    fn begin(&self, stage: Stage, pieces: usize) {
        let steps = self.subject.outside().map_or(0, |simulator| simulator.counts().steps);
        let (seconds, runs) = (self.begun.elapsed().as_secs_f64(), steps as f64 / FITTED);
        println!("{seconds:6.1} s, {runs:5.1} runs: {stage:?}, {pieces}");
    }

    fn advance(&self) {}

    fn plan(&self, text: &str) {
        println!("{text}");
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument =
        |i: usize, default: &str| arguments.get(i).cloned().unwrap_or_else(|| default.to_owned());
    let seconds: f64 = argument(0, "0.1").parse()?;
    let (kind, count): (String, usize) = (argument(1, "steps"), argument(2, "1").parse()?);
    let at_once = if argument(3, "") == "lanes" { [1, count] } else { [count, 1] };
    let to = tempfile::tempdir()?;
    let path = to.path().join("cart.csv");
    std::fs::write(&path, log()?)?;
    let request = Request::new("cart", [path]);
    let subject = Subject::lent(&request, simulator(seconds, &kind, at_once)?, None)?;
    let begun = Instant::now();
    let study = GapStudy::run_on(&request, &subject, &Said { begun, subject: &subject })?;
    let took = begun.elapsed().as_secs_f64();
    let (counts, trouble) = study.outside.ok_or("it is outside")?;
    println!("{}", study.report.headline);
    println!(
        "{seconds} s a run, {kind}, {} instances of {} lanes: {took:.1} s, {} runs and {} steps made, {:.1} s inside",
        at_once[0],
        at_once[1],
        counts.made,
        counts.steps,
        counts.inside.as_secs_f64()
    );
    trouble.map_or(Ok(()), |trouble| Err(trouble.into()))
}
