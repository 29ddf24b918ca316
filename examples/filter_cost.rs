//! What a sample costs in the filters of `fd-nonlinear`: the table of `docs/results/nonlinear.md`.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::{error::Error, time::Instant};

use fd_core::{Frame, stage::ResidualGenerator};
use fd_nonlinear::{
    Noise, NoisyModel, extended::ExtendedDesign, particle::ParticleDesign,
    unscented::UnscentedDesign,
};
use fd_sim::{model::Model, simulate::StateMap};

/// Samples of a block, and blocks; the fastest block counts, as others share the machine.
const SAMPLES: usize = 500;
const BLOCKS: usize = 30;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| states | integration steps per sample | extended [µs] | unscented [µs] | 1000 particles [µs] |"
    );
    println!("|---|---|---|---|---|");
    for tanks in [2, 5, 10] {
        let model: Model = row_of_tanks(tanks).parse()?;
        let map = StateMap::new(&model, &[], model.sample_time()?)?;
        let noise =
            Noise { process: vec![1e-3; tanks], output: vec![5e-3], initial: vec![0.05; tanks] };
        let steps = fd_sim::simulate::EquationSimulator::<f64>::new(&model)?.substeps();
        let noisy = NoisyModel::new(map, vec![1.0; tanks], noise)?;
        let mut extended = ExtendedDesign::new(noisy.clone()).freeze();
        let mut unscented = UnscentedDesign::new(noisy.clone(), None)?.freeze();
        let mut particles = ParticleDesign::new(noisy, 1000, 1)?.freeze();
        let costs = [
            cost(&mut extended, SAMPLES)?,
            cost(&mut unscented, SAMPLES)?,
            cost(&mut particles, SAMPLES / 50)?,
        ];
        let [extended, unscented, particles] = costs.map(|cost| format!("{cost:.1}"));
        println!("| {tanks} | {steps} | {extended} | {unscented} | {particles} |");
    }
    Ok(())
}

/// Tanks one after the other; the level of the last is measured.
fn row_of_tanks(count: usize) -> String {
    let state = |i: usize| {
        let inflow = if i == 1 { "q".to_owned() } else { format!("0.1*sqrt(h_{})", i - 1) };
        let law = format!("{inflow} - 0.1*sqrt(h_{i})");
        format!("h_{i} = {{ unit = \"m\", initial = 1.0, derivative = \"{law}\" }}\n")
    };
    let states: Vec<String> = (1..=count).map(state).collect();
    let states = states.concat();
    format!(
        "version = 1\nkind = \"equations\"\nname = \"tanks\"\nsample_time = 1.0\n\
         inputs = {{ q = {{ unit = \"m^3/s\" }} }}\n[states]\n{states}[outputs]\n\
         level = {{ unit = \"m\", value = \"h_{count}\" }}\n"
    )
}

/// Time of a sample in µs.
fn cost(generator: &mut dyn ResidualGenerator, samples: usize) -> Result<f64, Box<dyn Error>> {
    let (mut best, mut r) = (f64::INFINITY, [0.0]);
    for _ in 0..BLOCKS {
        let begin = Instant::now();
        for k in 0..samples {
            let y = [1.0 + 0.01 * (k as f64).sin()];
            generator.step(Frame::new(generator.io(), k as u64, &[0.1], &y)?, &mut r);
        }
        best = best.min(1e6 * begin.elapsed().as_secs_f64() / samples as f64);
    }
    Ok(best)
}
