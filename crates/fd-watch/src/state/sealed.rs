//! Files with a sum over their content, replaced as a whole.

use std::{fmt, path::Path};

use fd_model::file::write_atomically;
use serde::{Serialize, de::DeserializeOwned};

/// A sum over bytes (FNV-1a, Fowler, Noll and Vo 1991): it finds damage, not forgery.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum(u64);

impl Default for Sum {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Sum {
    pub(super) fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

impl fmt::Display for Sum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

fn sum_of(text: &str) -> String {
    let mut sum = Sum::default();
    sum.add(text.as_bytes());
    sum.to_string()
}

/// Writes a value as a line of JSON under the line of its sum. The folder is not yet synced.
pub(super) fn write(path: &Path, value: &impl Serialize) -> std::io::Result<()> {
    let json = serde_json::to_string(value)?;
    write_atomically(path, |out| writeln!(out, "{}\n{json}", sum_of(&json)))
}

/// Reads what was written.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    let (sum, json) = text.split_once('\n').ok_or("it has no sum in its first line")?;
    let json = json.strip_suffix('\n').ok_or("it is cut off")?;
    let found = sum_of(json);
    if sum != found {
        return Err(format!("expected the sum {sum} that was saved with it, found {found}"));
    }
    serde_json::from_str(json).map_err(|error| error.to_string())
}
