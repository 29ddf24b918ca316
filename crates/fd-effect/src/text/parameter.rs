//! Parameters and states of an effect of one's own.

use serde::{Deserialize, Serialize};

/// How far a strength goes that states no bounds, in parts of its size.
const FAR: f64 = 10.0;

/// A parameter of an effect of one's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextParameter {
    /// A change that is noticed, in its unit.
    pub size: f64,
    /// Its unit; a pure number if none is said.
    #[serde(default = "one")]
    pub unit: String,
    /// Values that make sense; of a strength from 0 to ten times its size if not said.
    #[serde(default)]
    pub bounds: Option<[f64; 2]>,
    /// Of a shape the value to start from. A parameter without is a strength: at 0 the effect is absent.
    #[serde(default)]
    pub shape: Option<f64>,
    /// Values to start fits from, besides those that follow from its size or shape.
    #[serde(default)]
    pub starts: Vec<f64>,
}

/// A state that an effect of one's own has, 0 at the start of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextState {
    /// Its unit; a pure number if none is said.
    #[serde(default = "one")]
    pub unit: String,
    /// Its rate, an expression like the law.
    pub derivative: String,
}

fn one() -> String {
    "1".to_owned()
}

impl TextParameter {
    pub(super) fn is_strength(&self) -> bool {
        self.shape.is_none()
    }

    /// Values that make sense.
    pub(super) fn range(&self) -> [f64; 2] {
        let middle = self.shape.unwrap_or(0.0);
        let low = if self.is_strength() { 0.0 } else { middle - FAR * self.size };
        self.bounds.unwrap_or([low, middle + FAR * self.size])
    }

    pub(super) fn problem(&self) -> Option<(&'static str, String, String)> {
        let Self { size, bounds, shape, .. } = self;
        if !(size.is_finite() && 0.0 < *size) {
            return Some((
                "size",
                "a change that is noticed, above 0".to_owned(),
                size.to_string(),
            ));
        }
        if let Some(value) = shape.filter(|value| !value.is_finite()) {
            return Some(("shape", "a finite value".to_owned(), value.to_string()));
        }
        let neutral = shape.unwrap_or(0.0);
        let [low, high] = self.range();
        let is_fine = low <= neutral && neutral <= high && low < high && (high - low).is_finite();
        (!is_fine).then(|| {
            let found = bounds.map_or_else(String::new, |[low, high]| format!("[{low}, {high}]"));
            ("bounds", format!("finite ones around {neutral}"), found)
        })
    }
}
