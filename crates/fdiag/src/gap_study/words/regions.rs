//! The quantities on which a gap depends, in words.

use fd_gap::locate::{RegionOf, RegionOn};

use super::labels::at;

/// What is looked at.
#[must_use]
pub fn region_of(of: &RegionOf) -> String {
    match of {
        RegionOf::Residual(output) => format!("residual of {output}"),
        RegionOf::Signal(site) => format!("missing signal {}", at(site)),
    }
}

/// The signal that it may depend on.
#[must_use]
pub fn region_on(on: &RegionOn) -> String {
    match on {
        RegionOn::Input(name) => format!("input {name}"),
        RegionOn::InputAmplitude(name) => format!("magnitude of input {name}"),
        RegionOn::State(name) => format!("state {name}"),
        RegionOn::StateAmplitude(name) => format!("magnitude of state {name}"),
        RegionOn::Output(name) => format!("output {name}"),
        RegionOn::Direction(site) => format!("direction of motion at {site}"),
    }
}
