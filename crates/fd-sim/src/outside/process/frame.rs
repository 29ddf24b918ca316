//! Frames: `u32 op, u32 lanes, u32 count, f64...`, little endian.

/// Version of the protocol that this program speaks.
pub const PROTOCOL_VERSION: u32 = 1;

/// What a frame is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum Op {
    Reset = 1,
    Step = 2,
    Rollout = 3,
    Measure = 4,
    Bye = 5,
}

impl Op {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Reset => "reset",
            Self::Step => "step",
            Self::Rollout => "rollout",
            Self::Measure => "measure",
            Self::Bye => "bye",
        }
    }
}

/// The op of an answer without values: the run cannot go on from here.
pub(super) const REFUSED: u32 = 0;
/// Bytes before the values.
pub(super) const HEAD: usize = 12;
/// Writes the head of a frame of so many lanes and values, into an empty buffer.
pub(super) fn begin(bytes: &mut Vec<u8>, op: Op, [lanes, count]: [u32; 2]) {
    bytes.clear();
    for word in [op as u32, lanes, count] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
}

/// Writes values.
pub(super) fn put(bytes: &mut Vec<u8>, values: &[f64]) {
    for value in values {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
}

/// The three words of a head.
pub(super) fn head(bytes: &[u8; HEAD]) -> [u32; 3] {
    std::array::from_fn(|i| {
        let mut word = [0; 4];
        word.copy_from_slice(&bytes[4 * i..4 * i + 4]);
        u32::from_le_bytes(word)
    })
}

/// Reads values, as many as there is room for.
pub(super) fn get(bytes: &[u8], values: &mut [f64]) {
    for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(8)) {
        let mut word = [0; 8];
        word.copy_from_slice(bytes);
        *value = f64::from_le_bytes(word);
    }
}
