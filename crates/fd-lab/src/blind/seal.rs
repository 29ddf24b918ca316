//! Sealed truths: nobody can read one by accident, and nobody can change one unseen.
//!
//! A commitment, SHA-256 of a nonce and the truth, lies beside each case. The truth itself lies
//! elsewhere, as nonce and text, encrypted with a keystream: block `i` is SHA-256 of key, name of
//! the case and `i`. Who has the directory of the truth has the key in it; the point is not secrecy
//! but that a diagnosis cannot see the truth unless it goes and opens it, and that the truth cannot
//! be changed after the diagnosis.

use sha2::{Digest, Sha256};

use super::error::BlindError;
use crate::hex::to_hex;

/// Length of a key and of a nonce.
pub(super) const LENGTH: usize = 32;

/// A secret.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SealKey([u8; LENGTH]);

impl SealKey {
    /// A new secret, from the system's random numbers.
    ///
    /// # Errors
    ///
    /// Returns an error when the system has none.
    pub fn random() -> Result<Self, BlindError> {
        let mut key = [0; LENGTH];
        getrandom::fill(&mut key)
            .map_err(|error| BlindError::Entropy { what: error.to_string() })?;
        Ok(Self(key))
    }

    /// Reads 64 hexadecimal digits.
    ///
    /// ```
    /// use fd_lab::blind::SealKey;
    ///
    /// let key = SealKey::parse(&"0f".repeat(32)).unwrap();
    /// assert_eq!(key.to_hex(), "0f".repeat(32));
    /// ```
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let bytes = from_hex(text.trim())?;
        Some(Self(bytes.try_into().ok()?))
    }

    /// As 64 hexadecimal digits.
    #[must_use]
    pub fn to_hex(&self) -> String {
        to_hex(&self.0)
    }

    fn nonce(&self, case: &str) -> [u8; LENGTH] {
        let hash = Sha256::new().chain_update(b"nonce").chain_update(self.0).chain_update(case);
        hash.finalize().into()
    }

    fn apply(&self, case: &str, bytes: &mut [u8]) {
        for (i, block) in bytes.chunks_mut(LENGTH).enumerate() {
            let hash = Sha256::new()
                .chain_update(b"stream")
                .chain_update(self.0)
                .chain_update((case.len() as u64).to_le_bytes())
                .chain_update(case)
                .chain_update((i as u64).to_le_bytes())
                .finalize();
            block.iter_mut().zip(hash).for_each(|(byte, key)| *byte ^= key);
        }
    }

    /// The sealed text, and the commitment to it.
    #[must_use]
    pub fn seal(&self, case: &str, text: &str) -> (Vec<u8>, String) {
        let mut bytes = self.nonce(case).to_vec();
        bytes.extend_from_slice(text.as_bytes());
        let commitment = to_hex(&Sha256::digest(&bytes));
        self.apply(case, &mut bytes);
        (bytes, commitment)
    }

    /// The text, if it is the one that was committed to.
    ///
    /// # Errors
    ///
    /// Returns an error when it is not.
    pub fn open(&self, case: &str, sealed: &[u8], commitment: &str) -> Result<String, BlindError> {
        let broken = || BlindError::Broken { case: case.to_owned() };
        let mut bytes = sealed.to_vec();
        self.apply(case, &mut bytes);
        if to_hex(&Sha256::digest(&bytes)) != commitment.trim() {
            return Err(broken());
        }
        let text = bytes.get(LENGTH..).ok_or_else(broken)?;
        String::from_utf8(text.to_vec()).map_err(|_| broken())
    }
}

fn from_hex(text: &str) -> Option<Vec<u8>> {
    if !text.is_ascii() || text.len() % 2 == 1 {
        return None;
    }
    (0..text.len() / 2).map(|i| u8::from_str_radix(&text[2 * i..2 * i + 2], 16).ok()).collect()
}
