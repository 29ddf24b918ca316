//! The state folder: what must survive a `kill -9`, a power cut and a full disk.
//!
//! ```text
//! DIR/state.json        whose state it is: version, model, spec, healthy samples
//! DIR/lock              held while a monitor runs
//! DIR/journal.ndjson    every alarm, synced before it is published
//! DIR/units/NAME.unit   the memory of a unit, replaced as a whole
//! DIR/units/NAME.rows   what a unit learned from, written once
//! DIR/samples/N.ndjson  samples of a source that was told to forget them, until their units are saved
//! DIR/outbox.json       how far a broker has confirmed the journal
//! ```

mod error;
mod folder;
mod identity;
mod intake;
mod journal;
mod outbox;
mod sealed;

pub use self::{error::StateError, folder::StateFolder, identity::Identity, outbox::Outbox};
