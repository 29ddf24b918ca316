//! The input, split into frequency bands, and how much of it is in each.

use faer::c64;
use fd_core::{Scalar, StateVisitor};

use crate::{
    detect::error::{DetectorError, positive},
    rows::DrivenRows,
};

/// Corners of the bands and the memory of their norms.
#[derive(Clone, Debug, PartialEq)]
pub struct Bands {
    /// `1 − α` of each low-pass, slowest first.
    keep: Vec<f64>,
    memory: f64,
}

impl Bands {
    /// Bands between `corners` in rad per sample, ascending, and the memory `N` of the norms in samples.
    ///
    /// ```
    /// use fd_compensate::detect::adaptive::Bands;
    ///
    /// assert_eq!(Bands::new(&[0.01, 0.1], 100.0)?.count(), 3);
    /// # Ok::<(), fd_compensate::detect::DetectorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when a corner is not positive and above the one before it, or the memory is
    /// below one sample.
    pub fn new(corners: &[f64], memory: f64) -> Result<Self, DetectorError> {
        let mut before = 0.0;
        for &corner in corners {
            positive("corner", corner)?;
            if corner <= before {
                let (parameter, expected) = ("corner", "above the one before it");
                return Err(DetectorError::Parameter { parameter, expected, found: corner });
            }
            before = corner;
        }
        if !(memory >= 1.0 && memory.is_finite()) {
            let (parameter, expected) = ("memory", "finite and at least 1 sample");
            return Err(DetectorError::Parameter { parameter, expected, found: memory });
        }
        Ok(Self { keep: corners.iter().map(|w| (-w).exp()).collect(), memory })
    }

    /// `corners` corners, evenly spaced on a logarithmic scale from `1 / slowest` to 1 rad per sample.
    ///
    /// # Errors
    ///
    /// Returns an error when `slowest` is not above one sample, or the memory is below.
    pub fn spaced(slowest: f64, corners: usize, memory: f64) -> Result<Self, DetectorError> {
        if !(slowest > 1.0 && slowest.is_finite()) {
            let (parameter, expected) = ("slowest time constant", "above 1 sample");
            return Err(DetectorError::Parameter { parameter, expected, found: slowest });
        }
        let steps = corners.saturating_sub(1).max(1) as f64;
        let spaced: Vec<f64> = (0..corners).map(|l| slowest.powf(l as f64 / steps - 1.0)).collect();
        Self::new(&spaced, memory)
    }

    /// Number of bands: one more than corners.
    #[must_use]
    pub fn count(&self) -> usize {
        self.keep.len() + 1
    }

    /// Memory `N` of the norms in samples.
    #[must_use]
    pub fn memory(&self) -> f64 {
        self.memory
    }

    /// Magnitudes `|φ_l|` at `omega` in rad per sample, slowest band first.
    #[must_use]
    pub fn gains(&self, omega: f64) -> Vec<f64> {
        let one = c64::new(1.0, 0.0);
        let back = c64::from_polar(1.0, -omega);
        let low_passes = self.keep.iter().map(|&keep| (1.0 - keep) / (one - back * keep));
        let mut before = c64::new(0.0, 0.0);
        low_passes
            .chain([one])
            .map(|low_pass| {
                let band = low_pass - before;
                before = low_pass;
                band.norm()
            })
            .collect()
    }
}

/// The largest norm of each input in each band over all runs, those of input 0 first.
pub(super) fn largest_norms(bands: &Bands, healthy: DrivenRows<'_>) -> Vec<f64> {
    let mut norms = InputNorms::<f64>::new(bands, healthy.nu());
    let mut largest = vec![0.0_f64; healthy.nu() * bands.count()];
    for run in healthy.runs() {
        norms.reset();
        for k in run {
            let now = norms.update(healthy.u(k));
            largest.iter_mut().zip(now).for_each(|(largest, norm)| *largest = largest.max(*norm));
        }
    }
    largest
}

/// The running norms `‖φ_l u_j‖`, those of input 0 first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct InputNorms<T> {
    smoothing: Vec<T>,
    forget: T,
    nu: usize,
    low_passed: Vec<T>,
    power: Vec<T>,
    norms: Vec<T>,
    /// Whether the filters have begun at a first input: 0 or 1.
    begun: u64,
}

impl<T: Scalar> InputNorms<T> {
    pub(super) fn new(bands: &Bands, nu: usize) -> Self {
        let zeros = |n: usize| vec![T::zero(); n];
        Self {
            smoothing: bands.keep.iter().map(|keep| T::from_design(1.0 - keep)).collect(),
            forget: T::from_design(bands.memory.recip()),
            nu,
            low_passed: zeros(nu * bands.keep.len()),
            power: zeros(nu * bands.count()),
            norms: zeros(nu * bands.count()),
            begun: 0,
        }
    }

    pub(super) fn nu(&self) -> usize {
        self.nu
    }

    /// How much of a new sample enters a mean.
    pub(super) fn forget(&self) -> T {
        self.forget
    }

    /// Takes one input and returns all norms.
    pub(super) fn update(&mut self, u: &[T]) -> &[T] {
        let filters = self.smoothing.len();
        let first = self.begun == 0;
        self.begun = 1;
        for (j, &u) in u.iter().enumerate() {
            let low_passed = &mut self.low_passed[j * filters..(j + 1) * filters];
            if first {
                low_passed.fill(u);
            }
            let slots = j * (filters + 1)..(j + 1) * (filters + 1);
            let power = &mut self.power[slots.clone()];
            let mut before = T::zero();
            for (l, power) in power.iter_mut().enumerate() {
                let up_to_here = match low_passed.get_mut(l) {
                    Some(state) => {
                        *state += self.smoothing[l] * (u - *state);
                        *state
                    }
                    None => u,
                };
                let band = up_to_here - before;
                before = up_to_here;
                let share = if first { T::one() } else { self.forget };
                *power += share * (band * band - *power);
            }
            for (norm, power) in self.norms[slots.clone()].iter_mut().zip(&self.power[slots]) {
                *norm = power.sqrt();
            }
        }
        &self.norms
    }

    pub(super) fn reset(&mut self) {
        self.low_passed.fill(T::zero());
        self.power.fill(T::zero());
        self.begun = 0;
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("input low-passes", &mut self.low_passed);
        visitor.reals("input powers", &mut self.power);
        visitor.counts("input begun", std::slice::from_mut(&mut self.begun));
    }
}
