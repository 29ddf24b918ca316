//! Types of the numbers in arrays, by the names that numpy gives them, and their values as `f64`.

use fd_core::memory::{self, MemoryError};

/// How one number is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    kind: Kind,
    pub bytes: usize,
    is_big_endian: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Float,
    Signed,
    Unsigned,
    /// Ticks of so many seconds, counted from the first value if they are dates.
    Time {
        tick_s: f64,
        is_date: bool,
    },
}

impl Number {
    /// Reads a type such as `<f8` or `<M8[ns]`.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let is_big_endian = text.starts_with('>');
        let text = text.trim_start_matches(['<', '>', '|', '=']);
        let (kind, rest) = text.split_at_checked(1)?;
        let (size, unit) = rest.split_once('[').map_or((rest, None), |(s, u)| (s, Some(u)));
        let bytes: usize = size.parse().ok()?;
        let kind = match (kind, bytes) {
            ("f", 2 | 4 | 8) => Kind::Float,
            ("i", 1 | 2 | 4 | 8) => Kind::Signed,
            ("u", 1 | 2 | 4 | 8) | ("b", 1) => Kind::Unsigned,
            ("M" | "m", 8) => {
                Kind::Time { tick_s: tick(unit?.strip_suffix(']')?)?, is_date: kind == "M" }
            }
            _ => return None,
        };
        Some(Self { kind, bytes, is_big_endian })
    }

    /// Numbers that lie one behind the other; `what` they are, where the system has no memory for them.
    pub(super) fn values<'a>(
        self,
        what: &str,
        raw: impl ExactSizeIterator<Item = &'a [u8]>,
    ) -> Result<Vec<f64>, MemoryError> {
        let mut values = memory::reserve(what, raw.len())?;
        let bits = raw.map(|cell| self.bits(cell));
        match self.kind {
            Kind::Float => values.extend(bits.map(|bits| self.float(bits))),
            Kind::Unsigned => values.extend(bits.map(|bits| bits as f64)),
            Kind::Signed => values.extend(bits.map(|bits| self.signed(bits) as f64)),
            Kind::Time { tick_s, is_date } => {
                let mut first = (!is_date).then_some(0);
                let seconds = bits.map(|bits| {
                    let ticks = self.signed(bits);
                    // numpy's "not a time".
                    if ticks == i64::MIN {
                        return f64::NAN;
                    }
                    // Subtracted as whole numbers: nanoseconds since 1970 have no room in an f64.
                    ticks.wrapping_sub(*first.get_or_insert(ticks)) as f64 * tick_s
                });
                values.extend(seconds);
            }
        }
        Ok(values)
    }

    fn bits(self, cell: &[u8]) -> u64 {
        let shift = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        let cell = &cell[..self.bytes.min(cell.len())];
        if self.is_big_endian {
            cell.iter().fold(0, shift)
        } else {
            cell.iter().rev().fold(0, shift)
        }
    }

    #[allow(clippy::cast_possible_wrap, reason = "the bits are those of a signed number")]
    fn signed(self, bits: u64) -> i64 {
        let unused = 64 - 8 * u32::try_from(self.bytes).unwrap_or(8);
        (bits << unused) as i64 >> unused
    }

    #[allow(clippy::cast_possible_truncation, reason = "there are as many bits as bytes")]
    fn float(self, bits: u64) -> f64 {
        match self.bytes {
            8 => f64::from_bits(bits),
            4 => f64::from(f32::from_bits(bits as u32)),
            _ => half(bits as u16),
        }
    }
}

/// A number of 16 bits (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    sign * match i32::from(bits >> 10 & 0x1f) {
        0 => fraction * 2.0_f64.powi(-14),
        31 if fraction > 0.0 => f64::NAN,
        31 => f64::INFINITY,
        exponent => (1.0 + fraction) * 2.0_f64.powi(exponent - 15),
    }
}

/// Seconds of a unit of numpy's times, such as `ns` or `10us`.
fn tick(unit: &str) -> Option<f64> {
    let letters = unit.trim_start_matches(|c: char| c.is_ascii_digit());
    let count = &unit[..unit.len() - letters.len()];
    let count: f64 = if count.is_empty() { 1.0 } else { count.parse().ok()? };
    let seconds = match letters {
        "W" => 604_800.0,
        "D" => 86_400.0,
        "h" => 3_600.0,
        "m" => 60.0,
        "s" => 1.0,
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        "ps" => 1e-12,
        _ => return None,
    };
    Some(count * seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::float_cmp, reason = "all of these are exact")]
    fn numbers_of_sixteen_bits() {
        for (bits, value) in [(0x3c00, 1.0), (0xc000, -2.0), (0x0001, 2.0_f64.powi(-24)), (0, 0.0)]
        {
            assert_eq!(half(bits), value);
        }
        assert!(half(0x7c00).is_infinite() && half(0x7e00).is_nan());
    }

    #[test]
    fn other_types_are_none() {
        for text in ["", "<", "O", "|O", "<U5", "<c16", "<f16", "<M8", "<M8[Y]", "é8", "|V3"] {
            assert_eq!(Number::parse(text), None, "{text}");
        }
    }
}
