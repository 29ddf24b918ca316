//! Standard deviations by channel, as a table of a spec.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::error::GeneratorSpecError;

/// Standard deviations of several channels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum DeviationSpec {
    /// The same fraction of the initial value of each.
    Relative(f64),
    /// By name, in the unit of the channel; others have what is usual for them.
    ByName(BTreeMap<String, f64>),
}

/// A channel: its name, its size, and what is usual for it; none where a number has to be given.
pub(super) struct Sized<'a> {
    pub name: &'a str,
    pub size: f64,
    pub usual: Option<f64>,
}

impl DeviationSpec {
    /// One number per channel.
    pub(super) fn of(
        spec: Option<&Self>,
        table: &'static str,
        channels: &[Sized<'_>],
    ) -> Result<Vec<f64>, GeneratorSpecError> {
        if let Some(Self::ByName(named)) = spec
            && let Some(found) = named.keys().find(|name| channels.iter().all(|c| c.name != **name))
        {
            let known: Vec<String> = channels.iter().map(|c| format!("`{}`", c.name)).collect();
            let (known, found) = (known.join(", "), found.clone());
            return Err(GeneratorSpecError::Unknown { table, known, found });
        }
        let one = |channel: &Sized<'_>| {
            let name = || channel.name.to_owned();
            match spec {
                Some(Self::Relative(share)) if channel.size.abs() > 0.0 => {
                    Ok(share * channel.size.abs())
                }
                Some(Self::Relative(_)) => {
                    Err(GeneratorSpecError::NoSize { table, channel: name() })
                }
                Some(Self::ByName(named)) => (named.get(channel.name).copied())
                    .or(channel.usual)
                    .ok_or_else(|| GeneratorSpecError::Missing { table, channel: name() }),
                None => channel
                    .usual
                    .ok_or_else(|| GeneratorSpecError::Missing { table, channel: name() }),
            }
        };
        channels.iter().map(one).collect()
    }
}
