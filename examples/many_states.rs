//! Any number of independent states as equations, and logs of a plant whose input has a dead zone:
//!
//! ```sh
//! cargo run --release --example many_states -- 60 1000 lags
//! fdiag gap --model lags/model.toml --log lags/monday.csv --held-out lags/friday.csv
//! ```
//!
//! Lags behind one input, each measured, each with a time constant that is known to 3 %.

use std::{error::Error, fmt::Write, fs, path::PathBuf};

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Time between samples, s.
const TS: f64 = 0.01;
/// Fastest time constant, s, and how much slower the next is.
const FASTEST: f64 = 0.05;
const RATIO: f64 = 1.02;
/// Standard deviation of the noise, V.
const NOISE: f64 = 0.01;
/// Half width of the dead zone, V.
const DEAD_ZONE: f64 = 0.3;
/// Largest input, V, and for how many samples it stays.
const PEAK: f64 = 2.0;
const HELD: usize = 25;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(states), Some(samples), Some(directory)) =
        (arguments.next(), arguments.next(), arguments.next())
    else {
        return Err("usage: many_states STATES SAMPLES DIRECTORY".into());
    };
    let (states, samples): (usize, usize) = (states.parse()?, samples.parse()?);
    let directory = PathBuf::from(directory);
    fs::create_dir_all(&directory)?;
    let times: Vec<f64> =
        std::iter::successors(Some(FASTEST), |time| Some(RATIO * time)).take(states).collect();
    fs::write(directory.join("model.toml"), model(&times)?)?;
    for (name, seed) in [("monday", 1), ("friday", 2)] {
        fs::write(directory.join(format!("{name}.csv")), log(&times, samples, seed)?)?;
    }
    Ok(())
}

fn model(times: &[f64]) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    writeln!(text, "version = 1\nkind = \"equations\"\nname = \"lags\"\nsample_time = {TS}\n")?;
    writeln!(text, "[inputs]\nu = {{ unit = \"V\" }}\n\n[parameters]")?;
    for (i, time) in times.iter().enumerate() {
        writeln!(text, "T{i} = {{ unit = \"s\", value = {time:.6}, tolerance = 0.03 }}")?;
    }
    writeln!(text, "\n[states]")?;
    for i in 0..times.len() {
        let law = format!("(u - x{i})/T{i}");
        writeln!(text, "x{i} = {{ unit = \"V\", initial = 0.0, derivative = \"{law}\" }}")?;
    }
    writeln!(text, "\n[outputs]")?;
    for i in 0..times.len() {
        writeln!(text, "y{i} = {{ unit = \"V\", value = \"x{i}\", noise = {NOISE} }}")?;
    }
    Ok(text)
}

/// The exact answer of the lags to an input that stays between samples, with noise.
fn log(times: &[f64], samples: usize, seed: u64) -> Result<String, std::fmt::Error> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    // The sum of twelve uniform numbers has variance 1.
    let noise = |random: &mut Xoshiro256PlusPlus| -> f64 {
        NOISE * ((0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0)
    };
    let mut text = String::from("t,u");
    for i in 0..times.len() {
        write!(text, ",y{i}")?;
    }
    let (mut x, mut u) = (vec![0.0; times.len()], 0.0);
    for k in 0..samples {
        if k % HELD == 0 {
            u = random.random_range(-PEAK..PEAK);
        }
        write!(text, "\n{:.2},{u:.6}", k as f64 * TS)?;
        let arrives = u - u.clamp(-DEAD_ZONE, DEAD_ZONE);
        for (x, time) in x.iter_mut().zip(times) {
            write!(text, ",{:.6}", *x + noise(&mut random))?;
            *x = arrives + (*x - arrives) * (-TS / time).exp();
        }
    }
    text.push('\n');
    Ok(text)
}
