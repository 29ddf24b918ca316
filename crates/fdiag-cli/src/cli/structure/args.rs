//! What can be asked of `fdiag structure`.

use std::path::PathBuf;

use clap::Args;
use fd_structure::equations::FaultPlaces;

use super::super::output::OutputArgs;

pub(crate) const STRUCTURE_HELP: &str = "\
Examples:
  fdiag structure --model examples/models/tanks.toml
  fdiag structure --model examples/models/tanks.toml --faults sensors,q_1
  fdiag structure --model examples/models/dc_drive.toml --measurable i,omega --sensors-may-fail

docs/structure.md says how to read the answer.";

#[derive(Debug, Args)]
pub(crate) struct StructureArgs {
    /// Model file (TOML) with equations as text, or a linear one
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// Where faults are assumed, with commas: sensors, actuators, laws, definitions, all, none, and
    /// inputs, states, definitions and outputs by name
    #[arg(long, value_name = "LIST", default_value = "sensors,actuators,laws")]
    pub faults: FaultPlaces,
    /// Unknowns that could be measured with more sensors, with commas; without it all but rates
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub measurable: Vec<String>,
    /// New sensors may fail, and their faults must be isolated as well
    #[arg(long)]
    pub sensors_may_fail: bool,
    /// Most minimal overdetermined sets, and most test supports, that are listed
    #[arg(long, value_name = "N", default_value_t = 10_000,
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub most: u32,
    #[command(flatten)]
    pub output: OutputArgs,
}
