//! Numbers one behind the other, aligned or not.

use super::Number;

/// The bytes of a message, read from the front.
#[derive(Clone, Copy, Debug)]
pub(in crate::format) struct Bytes<'a> {
    data: &'a [u8],
    at: usize,
    /// Numbers begin at a multiple of their length, up to this.
    align: usize,
    is_big_endian: bool,
}

impl<'a> Bytes<'a> {
    /// Little endian, without gaps.
    #[cfg(feature = "ulog")]
    pub(in crate::format) fn dense(data: &'a [u8]) -> Self {
        Self { data, at: 0, align: 1, is_big_endian: false }
    }

    /// CDR as ROS 2 writes it (OMG RTPS 2.3, 10.2): four bytes that say how, then aligned numbers.
    #[cfg(any(feature = "mcap", feature = "rosbag"))]
    pub(in crate::format) fn cdr(data: &'a [u8]) -> Option<Self> {
        let (head, data) = data.split_at_checked(4)?;
        let is_big_endian = match head {
            [0, 0, ..] => true,
            [0, 1, ..] => false,
            _ => return None,
        };
        Some(Self { data, at: 0, align: 8, is_big_endian })
    }

    /// Bytes that are left.
    pub(super) fn left(&self) -> usize {
        self.data.len().saturating_sub(self.at)
    }

    /// So many bytes as they are.
    pub(super) fn take(&mut self, bytes: usize) -> Option<&'a [u8]> {
        let taken = self.data.get(self.at..self.at.checked_add(bytes)?)?;
        self.at += bytes;
        Some(taken)
    }

    /// The next number as bits.
    pub(in crate::format) fn bits(&mut self, bytes: usize) -> Option<u64> {
        self.at = self.at.checked_next_multiple_of(self.align.min(bytes).max(1))?;
        let taken = self.take(bytes)?;
        let shift = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        Some(if self.is_big_endian {
            taken.iter().fold(0, shift)
        } else {
            taken.iter().rev().fold(0, shift)
        })
    }

    /// How many things follow.
    pub(super) fn length(&mut self) -> Option<usize> {
        usize::try_from(self.bits(4)?).ok()
    }

    /// The next number.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        reason = "there are as many bits as bytes, and they are those of a signed number"
    )]
    pub(super) fn number(&mut self, number: Number) -> Option<f64> {
        let bits = self.bits(number.bytes())?;
        Some(match number {
            Number::Unsigned(_) => bits as f64,
            Number::Signed(bytes) => {
                let unused = 64 - 8 * u32::try_from(bytes).ok()?;
                ((bits << unused) as i64 >> unused) as f64
            }
            Number::Float(4) => f64::from(f32::from_bits(bits as u32)),
            Number::Float(_) => f64::from_bits(bits),
        })
    }
}
