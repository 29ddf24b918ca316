//! Which instructions this processor has.

use std::{fmt, sync::OnceLock};

use pulp::WithSimd;

/// Instructions that estimators side by side are computed with.
///
/// # Examples
///
/// ```
/// use fd_ident::batch::Machine;
///
/// // The best there is comes first, one number at a time last.
/// let names: Vec<String> = Machine::all().iter().map(ToString::to_string).collect();
/// assert_eq!(names[0], Machine::detect().to_string());
/// assert_eq!(names.last().map(String::as_str), Some("scalar"));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Machine(pulp::Arch);

impl Machine {
    /// The widest registers of this processor.
    #[must_use]
    pub fn detect() -> Self {
        // Asking the processor takes longer than a short block.
        static ARCH: OnceLock<pulp::Arch> = OnceLock::new();
        Self(*ARCH.get_or_init(pulp::Arch::new))
    }

    /// All that this processor can do, the widest first.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all = vec![Self::detect()];
        #[cfg(target_arch = "x86_64")]
        if let (pulp::Arch::V4(_), Some(v3)) = (all[0].0, pulp::x86::V3::try_new()) {
            all.push(Self(pulp::Arch::V3(v3)));
        }
        if !matches!(all[0].0, pulp::Arch::Scalar) {
            all.push(Self(pulp::Arch::Scalar));
        }
        all
    }

    #[inline]
    pub(super) fn run<W: WithSimd>(self, work: W) -> W::Output {
        self.0.dispatch(work)
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            #[cfg(target_arch = "x86_64")]
            pulp::Arch::V4(_) => "AVX-512",
            #[cfg(target_arch = "x86_64")]
            pulp::Arch::V3(_) => "AVX2",
            #[cfg(target_arch = "aarch64")]
            pulp::Arch::Neon(_) => "NEON",
            pulp::Arch::Scalar => "scalar",
            _ => "wide registers",
        })
    }
}
