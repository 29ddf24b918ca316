//! A log of a jet engine with one cause that simulators lack, to try `fdiag gap` on.
//!
//! ```sh
//! cargo run --release -p fd-lab --example gap_engine_log -- worn.csv hpc_efficiency=-0.015 7
//! fdiag gap --model examples/gap/engine/engine.toml --log worn.csv
//! ```
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use fd_lab::engine_gap::{EngineCause, engine_log};
use fdiag::{
    engine_plant::EngineKnowledge, jetengine::engine17::HealthParameter, log::write_log,
    model::SampleTime,
};

/// Samples of a log: 24 s.
const SAMPLES: usize = 600;
const USAGE: &str = "usage: gap_engine_log FILE [CAUSE=STRENGTH [SEED]]\n\
    causes: a parameter of the engine's health with its shift (hpc_efficiency=-0.015,\n\
    bleed_leak=0.01, ...), T_7_lag, P_6_lag or fuel_lag in s, fuel_rate in kg/s per s,\n\
    heat_soak as a multiple of the reference conductance";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (file, cause, seed) = match arguments.as_slice() {
        [file] => (file, EngineCause::Nothing, 1),
        [file, cause] => (file, parse(cause)?, 1),
        [file, cause, seed] => (file, parse(cause)?, seed.parse()?),
        _ => return Err(USAGE.into()),
    };
    // Samples every 40 ms, from the reference point on.
    let known = EngineKnowledge::at(0.712, SampleTime::new(0.04)?);
    let log = engine_log(&known, cause, SAMPLES, seed)?;
    write_log(file, &rounded(&log)?)?;
    println!("{file}: {cause:?}, seed {seed}");
    Ok(())
}

fn parse(text: &str) -> Result<EngineCause, Box<dyn Error>> {
    let (name, strength) = text.split_once('=').ok_or(USAGE)?;
    let strength: f64 = strength.parse()?;
    let health = HealthParameter::ALL.into_iter().find(|parameter| parameter.name() == name);
    Ok(match name {
        "T_7_lag" => EngineCause::SensorLag(2, strength),
        "P_6_lag" => EngineCause::SensorLag(3, strength),
        "fuel_lag" => EngineCause::FuelLag(strength),
        "fuel_rate" => EngineCause::FuelRateLimit(strength),
        "heat_soak" => EngineCause::HeatSoak(strength),
        _ => EngineCause::Health(health.ok_or(USAGE)?, strength),
    })
}

/// Seven digits are enough, for a thousandth of the noise, and keep files small.
fn rounded(log: &fdiag::model::Record) -> Result<fdiag::model::Record, Box<dyn Error>> {
    let round =
        |value: &f64| -> Result<f64, Box<dyn Error>> { Ok(format!("{value:.6e}").parse()?) };
    let all =
        |values: &mut dyn Iterator<Item = &f64>| values.map(round).collect::<Result<Vec<_>, _>>();
    let u = all(&mut log.samples().flat_map(|(u, _)| u))?;
    let y = all(&mut log.samples().flat_map(|(_, y)| y))?;
    Ok(fdiag::model::Record::new(log.inputs().to_vec(), log.outputs().to_vec(), u, y, log.ts())?)
}
