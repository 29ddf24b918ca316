//! From what a diagnosis decides at every sample to the few messages that people can act on, as they know it from
//! alarm systems of plants (ANSI/ISA-18.2-2016): one persistent fault is one alarm.

mod annunciator;
mod audit;
mod flood;
mod settings;

pub(crate) use self::annunciator::{Annunciator, Heard, Said};
pub(crate) use self::flood::Floods;
pub use self::{
    audit::{Audit, Counted},
    settings::{AlarmSettings, SettingsError, Shelf},
};
