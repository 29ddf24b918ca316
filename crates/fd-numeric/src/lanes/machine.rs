//! Which instructions this processor has.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use std::{fmt, marker::PhantomData, sync::OnceLock};

use pulp::{Simd, WithSimd};

use super::registers::LaneScalar;

/// Instructions that numbers side by side are computed with.
///
/// # Examples
///
/// ```
/// use fd_numeric::lanes::Machine;
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

    /// The same, or the next narrower one where its registers hold more numbers than rows of so
    /// many `f64` can fill.
    #[must_use]
    pub fn for_rows_of(self, numbers: usize) -> Self {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            pulp::Arch::V4(wide) if !numbers.is_multiple_of(8) => Self(pulp::Arch::V3(*wide)),
            _ => self,
        }
    }

    /// Does some work, in code that is compiled for this machine.
    #[inline]
    pub fn run<T: LaneScalar, W: Work<T>>(self, work: W) -> W::Output {
        self.0.dispatch(Waiting { work, lanes: PhantomData })
    }
}

/// Something to be computed with registers. `run` should be `#[inline(always)]`, and so should all
/// that it calls.
pub trait Work<T: LaneScalar> {
    /// What comes out.
    type Output;

    /// Computes it.
    fn run<S: Simd>(self, registers: T::Registers<S>) -> Self::Output;
}

/// Work that waits for a machine.
struct Waiting<W, T> {
    work: W,
    lanes: PhantomData<T>,
}

impl<T: LaneScalar, W: Work<T>> WithSimd for Waiting<W, T> {
    type Output = W::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> W::Output {
        self.work.run(T::registers(simd))
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
