//! A log of any length for the cart of the quick start, which rubs with 0.4 N:
//! `cargo run --release --example long_log -- 1000000 > long.csv`, then
//! `fdiag gap --model examples/gap/quick-start/model.toml --log long.csv`.

use std::{
    env,
    error::Error,
    io::{self, BufWriter, Write},
};

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Integration steps per sample of 10 ms.
const STEPS: u32 = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let rows: usize = env::args().nth(1).ok_or("how many rows?")?.parse()?;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut out = BufWriter::new(io::stdout().lock());
    writeln!(out, "time [s],force [N],speed [m/s]")?;
    let (mut v, mut force) = (0.0_f64, 0.0);
    for k in 0..rows {
        if k % 40 == 0 {
            force = random.random_range(-3.0..3.0);
        }
        // Twelve uniform numbers make one that is nearly normal.
        let noise: f64 = (0..12).map(|_| random.random_range(-0.5..0.5)).sum();
        writeln!(out, "{:.2},{force:.6},{:.6}", k as f64 / 100.0, v + 0.004 * noise)?;
        for _ in 0..STEPS {
            let drive = force - 1.5 * v;
            let rubs = if v == 0.0 { drive.clamp(-0.4, 0.4) } else { 0.4 * v.signum() };
            let next = v + (drive - rubs) / 1.2 * 0.01 / f64::from(STEPS);
            // It stands before it turns.
            v = if v * next < 0.0 { 0.0 } else { next };
        }
    }
    Ok(())
}
