//! Simulators outside this program: a process in any language, an FMU.
//!
//! | module | what it is for |
//! |---|---|
//! | [`Contract`] | channels, parameters, states, ports and capabilities of such a simulator |
//! | [`OutsideSimulator`] | a [`Simulator`](crate::simulate::Simulator) on top of it: leased instances, remembered runs, counts |
//! | [`Process`] | a program, over its standard input and output |
//! | `Fmu` | a unit for co-simulation, FMI 2.0 or 3.0, behind the feature `fmu` |
//! | `host_fmus`, `serve_fmu` | the two sides of an FMU in a process of its own |
//! | [`OutsideFile`] | its model file |
//! | [`check()`] | whether a simulator keeps its promises |
//!
//! A diagnosis runs a simulator some thousand times, in hundreds of copies. An outside simulator is expensive.
//! Therefore copies cost nothing; a few running instances are leased to them from the first step of a run to
//! its last; whole runs are one call where the simulator can do that; and no run is made twice.

mod check;
mod contract;
mod disposable;
mod drive;
mod error;
mod file;
#[cfg(feature = "fmu")]
mod fmu;
mod grain;
mod leftovers;
mod loan;
mod lock;
mod memory;
mod native;
mod pool;
mod powers;
#[cfg(unix)]
mod process;
mod programs;
mod simulator;
mod source;
mod spread;
mod stated;
mod sync;
mod tally;
mod tapes;

#[cfg(feature = "fmu")]
pub use self::fmu::Fmu;
#[cfg(all(unix, feature = "fmu"))]
pub use self::fmu::{host_fmus, serve_fmu};
#[cfg(unix)]
pub use self::process::{PROTOCOL_VERSION, Process, serve, stated};
pub use self::{
    check::{Checked, Conformance, Grade, check, check_driven},
    contract::{Contract, Motion},
    drive::Drive,
    error::OutsideError,
    file::{OUTSIDE_KINDS, OutsideFile},
    leftovers::end_programs,
    powers::Powers,
    programs::{NoPrograms, forbid_programs, programs_are_forbidden},
    simulator::OutsideSimulator,
    source::{Instance, Lane, Lost, Source, Start, by_lanes, by_steps},
    spread::Spread,
    stated::{Entry, Stated},
    tally::Counts,
};
