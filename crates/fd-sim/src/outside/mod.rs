//! Simulators outside of this program: a process of any language, an FMU.
//!
//! | module | what it is for |
//! |---|---|
//! | [`Contract`] | channels, parameters, states, ports and powers of such a simulator |
//! | [`OutsideSimulator`] | a [`Simulator`](crate::simulate::Simulator) of it: leased instances, a memory, counts |
//! | [`Process`] | a program, over its standard input and output |
//! | `Fmu` | a unit for co-simulation, FMI 2.0, behind the feature `fmu` |
//! | [`OutsideFile`] | the model file of it |
//! | [`check()`] | whether a simulator keeps its promises |
//!
//! A diagnosis runs a simulator some thousand times, in copies of which there are hundreds. An outside
//! simulator is dear: so copies cost nothing, a few running instances are lent to them from the first step of a
//! run to its last, whole runs are one call where the simulator can do that, and nothing is asked twice.

mod check;
mod contract;
mod drive;
mod error;
mod file;
#[cfg(feature = "fmu")]
mod fmu;
mod grain;
mod loan;
mod lock;
mod memory;
mod native;
mod pool;
#[cfg(unix)]
mod process;
mod simulator;
mod source;
mod tally;

#[cfg(feature = "fmu")]
pub use self::fmu::Fmu;
#[cfg(unix)]
pub use self::process::{PROTOCOL_VERSION, Process, serve, stated};
pub use self::{
    check::{Checked, Conformance, Grade, check, check_driven},
    contract::{Contract, Entry, Motion, Powers, Stated},
    drive::Drive,
    error::OutsideError,
    file::{OUTSIDE_KINDS, OutsideFile},
    simulator::OutsideSimulator,
    source::{Instance, Lane, Lost, Source, Start, by_steps},
    tally::Counts,
};
