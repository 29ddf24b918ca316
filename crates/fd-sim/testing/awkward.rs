//! A sprung mass, served as a process, that misbehaves as its first argument says; or an FMU. For tests.
#![allow(clippy::print_stderr, reason = "last words, to be quoted")]

use std::{
    fs::OpenOptions,
    io::{self, Write},
    process::exit,
    thread::sleep,
    time::Duration,
};

use fd_model::{Channel, SampleTime};
use fd_sim::{
    model::{Model, Parameter},
    outside::{Powers, serve, stated},
    simulate::{EquationSimulator, Initial, Port, Simulator},
};

/// The plant; tests have the same text in this process.
const MASS: &str = include_str!("mass.toml");

/// What it does wrong.
#[derive(Clone, Debug, Default)]
struct Manner {
    /// What it is: `die`, `hang`, `nan`, ...
    kind: String,
    /// From which step of a run on.
    step: usize,
    /// A file that remembers that it was done, where it is done only once.
    once: Option<String>,
}

impl Manner {
    fn is(&self, kind: &str) -> bool {
        self.kind == kind
            && self.once.as_ref().is_none_or(|file| {
                // Made by the first one; whoever comes later finds it there.
                OpenOptions::new().write(true).create_new(true).open(file).is_ok()
            })
    }
}

/// A simulator with a manner.
#[derive(Clone, Debug)]
struct Awkward {
    inner: Box<dyn Simulator>,
    manner: Manner,
    steps: usize,
    mass: f64,
}

impl Simulator for Awkward {
    fn ts(&self) -> SampleTime {
        self.inner.ts()
    }

    fn inputs(&self) -> &[Channel] {
        self.inner.inputs()
    }

    fn outputs(&self) -> &[Channel] {
        self.inner.outputs()
    }

    fn parameters(&self) -> &[Parameter] {
        self.inner.parameters()
    }

    fn initial(&self) -> &[Initial] {
        self.inner.initial()
    }

    fn ports(&self) -> &[Port] {
        self.inner.ports()
    }

    fn start(&mut self, theta: &[f64], x0: &[f64], first: u64) {
        (self.steps, self.mass) = (0, theta[0]);
        self.inner.start(theta, x0, first);
        if self.manner.kind == "leftover" {
            // The second parameter of the run before.
            self.manner.step += 1;
        }
    }

    fn step(&mut self, u: &[f64], u_next: &[f64], f: &[f64], y: &mut [f64]) {
        self.inner.step(u, u_next, f, y);
        self.steps += 1;
        if self.manner.kind == "leftover" {
            y[0] += 1e-3 * self.manner.step as f64;
        }
        if self.manner.kind == "single" {
            for y in y.iter_mut() {
                *y = f64::from(single(*y));
            }
        }
        if self.manner.step < self.steps {
            if self.manner.is("die") || (self.manner.kind == "die-when-light" && self.mass < 1.0) {
                eprintln!("out of licences");
                eprintln!("at step {}", self.steps);
                exit(3);
            }
            if self.manner.is("hang") {
                sleep(Duration::from_secs(3600));
            }
            if self.manner.is("nan") {
                y.fill(f64::NAN);
            }
        }
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> bool {
        self.inner.measure(u, y);
        if self.manner.kind == "single" {
            for y in y.iter_mut() {
                *y = f64::from(single(*y));
            }
        }
        true
    }

    fn state(&self) -> &[f64] {
        self.inner.state()
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }
}

#[expect(clippy::cast_possible_truncation, reason = "that is the point")]
fn single(value: f64) -> f32 {
    value as f32
}

/// Standard output, with frames that are not what they should be.
struct Lies<W> {
    out: W,
    kind: String,
    frames: usize,
}

impl<W: Write> Write for Lies<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut told = bytes.to_vec();
        let is_frame = 12 <= bytes.len() && bytes[0] < 6 && bytes[1..4] == [0; 3];
        self.frames += usize::from(is_frame);
        // The first frame answers to the reset with which everybody begins.
        if is_frame && 1 < self.frames {
            match self.kind.as_str() {
                "count" => told[8] += 1,
                "huge" => told[8..12].fill(0xff),
                "op" => told[0] ^= 7,
                "short" => told.truncate(bytes.len() - 4),
                "refuse" => told = vec![0; 12],
                _ => {}
            }
        }
        self.out.write_all(&told)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let kind = arguments.next().unwrap_or_default();
    #[cfg(all(unix, feature = "fmu"))]
    if kind == "fmu" {
        // An FMU, with nothing awkward but what is in it.
        let path = arguments.next().unwrap_or_default();
        return fd_sim::outside::serve_fmu(path.as_ref(), None).map_err(|error| {
            eprintln!("{error}");
            exit(1)
        });
    }
    let step = arguments.next().map_or(Ok(0), |step| step.parse())?;
    let manner = Manner { kind: kind.clone(), step, once: arguments.next() };
    if let (true, Some(file)) = (kind == "tell", &manner.once) {
        std::fs::write(file, std::process::id().to_string())?;
    }
    let model: Model = MASS.parse()?;
    let inner = EquationSimulator::<f64>::with_ports(&model, model.sample_time()?)?;
    let noise: Vec<Option<f64>> = model.outputs.iter().map(|output| output.noise).collect();
    let mut hello = stated(&model.name, &inner, &noise);
    hello.ports[0].velocity = Some("speed".to_owned());
    hello.ports[0].position = Some("place".to_owned());
    let powers = hello.powers.unwrap_or_default();
    let mut simulator = Awkward { inner: Box::new(inner), manner, steps: 0, mass: f64::INFINITY };

    let (input, mut output) = (io::stdin().lock(), io::stdout().lock());
    let line = match kind.as_str() {
        "chatty" => Some("Loading the model ...\n"),
        "old" => Some(
            "{\"version\": 0, \"sample_time\": 0.02, \"outputs\": [{\"name\": \"y\", \"unit\": \"m\"}]}\n",
        ),
        "empty" => Some("{\"version\": 1, \"sample_time\": 0.02}\n"),
        "unknown" => Some(
            "{\"version\": 1, \"sample_time\": 0.02, \"outputs\": [{\"name\": \"y\", \"units\": \"m\"}]}\n",
        ),
        "wordy" => Some(
            "{\"version\": 1, \"sample_time\": 0.02, \"outputs\": [{\"name\": \"y\", \"unit\": \"m\"}]}\nready\n",
        ),
        "endless" => Some(""),
        _ => None,
    };
    if let Some(line) = line {
        output.write_all(line.as_bytes())?;
        output.flush()?;
        sleep(Duration::from_secs(3600));
    }
    match kind.as_str() {
        "quit" => exit(7),
        "deaf" => {
            // Says hello, then neither reads nor writes.
            serve(&mut simulator, &hello, &b"{}\n"[..], &mut output)?;
            sleep(Duration::from_secs(3600));
        }
        "steps" => {
            hello.powers = Some(Powers { rollout: false, measure: false, states: false, ..powers });
        }
        "runs" => {
            hello.powers = Some(Powers { step: false, ..powers });
        }
        "lanes" => {
            hello.powers = Some(Powers { lanes: 8, ..powers });
        }
        "lanes of runs" => {
            hello.powers = Some(Powers { lanes: 8, measure: false, states: false, ..powers });
        }
        _ => {}
    }
    let lies = Lies { out: output, kind, frames: 0 };
    Ok(serve(&mut simulator, &hello, input, lies)?)
}
