//! Which residual reacts to which fault.

use std::fmt;

use faer::{Mat, c64};
use fd_model::{StateSpace, TimeDomain};

use crate::{
    error::DesignError,
    form::{ResidualForm, frequency_grid, is_clear},
};

/// Gains below this fraction of what would be possible without cancellation count as zero.
const ZERO: f64 = 1e-9;

/// The faults that a residual reacts to, printed as `1101`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Signature(pub Vec<bool>);

impl fmt::Display for Signature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|&bit| write!(f, "{}", u8::from(bit)))
    }
}

/// One signature per residual channel: a bit is set when the fault reaches the channel at any
/// frequency.
///
/// # Errors
///
/// Returns an error when `gf` has other outputs or another sample time than the plant.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::{Discrete, SampleTime, StateSpace};
/// use fd_residual::{
///     GeneratorDesign,
///     analysis::{strong_structure, weak_structure},
///     parity::ParityDesign,
/// };
///
/// // An integrator's parity relation y(k) − y(k−1) − u(k−1) forgets a constant sensor fault.
/// let domain = Discrete { ts: SampleTime::new(1.0)? };
/// let tank = StateSpace::new(mat![[1.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
/// let gf = StateSpace::gain(mat![[1.0]], domain)?;
/// let form = ParityDesign::all(&tank, 1)?.form()?;
/// assert_eq!(weak_structure(&form, &gf)?[0].to_string(), "1");
/// assert_eq!(strong_structure(&form, &gf, &[0.0])?[0].to_string(), "0");
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
pub fn weak_structure<D: TimeDomain>(
    form: &ResidualForm<D>,
    gf: &StateSpace<D>,
) -> Result<Vec<Signature>, DesignError> {
    let visibility = Visibility::of(form, gf)?;
    Ok(signatures(form, gf, |row, fault| visibility.reacts_somewhere(row, fault)))
}

/// One signature per residual channel: a bit is set when the fault reaches the channel at every
/// one of the given frequencies (rad/s; 0 for constant faults).
///
/// # Errors
///
/// Returns an error when `gf` has other outputs or another sample time than the plant.
pub fn strong_structure<D: TimeDomain>(
    form: &ResidualForm<D>,
    gf: &StateSpace<D>,
    frequencies: &[f64],
) -> Result<Vec<Signature>, DesignError> {
    let visibility = Visibility::of(form, gf)?;
    Ok(signatures(form, gf, |row, fault| {
        frequencies.iter().all(|&omega| visibility.reacts(row, fault, omega))
    }))
}

fn signatures<D: TimeDomain>(
    form: &ResidualForm<D>,
    gf: &StateSpace<D>,
    bit: impl Fn(usize, usize) -> bool,
) -> Vec<Signature> {
    (0..form.residual_len())
        .map(|row| Signature((0..gf.nu()).map(|fault| bit(row, fault)).collect()))
        .collect()
}

/// Decides whether `|[H_y]_row [G_f]_fault|` is zero, against the size of its factors.
pub(crate) struct Visibility<'a, D> {
    form: &'a ResidualForm<D>,
    gf: &'a StateSpace<D>,
    poles: Vec<c64>,
    /// Largest entry of each pair over the grid, where it stands out from rounding.
    largest: Mat<f64>,
}

impl<'a, D: TimeDomain> Visibility<'a, D> {
    pub(crate) fn of(
        form: &'a ResidualForm<D>,
        gf: &'a StateSpace<D>,
    ) -> Result<Self, DesignError> {
        // Also checks that the two fit.
        form.residual_of(gf)?;
        let grid = frequency_grid(&[form.system(), gf])?;
        let mut largest = Mat::zeros(form.residual_len(), gf.nu());
        let mut poles = form.system().poles()?;
        poles.extend(gf.poles()?);
        let mut visibility = Self { form, gf, poles, largest: largest.clone() };
        for omega in grid {
            let Some((hy, g)) = visibility.factors(omega) else { continue };
            for row in 0..largest.nrows() {
                for fault in 0..largest.ncols() {
                    let (gain, scale) = entry(&hy, &g, row, fault);
                    if ZERO * scale < gain {
                        largest[(row, fault)] = gain.max(largest[(row, fault)]);
                    }
                }
            }
        }
        visibility.largest = largest;
        Ok(visibility)
    }

    /// Whether the fault reaches the residual channel at any frequency.
    pub(crate) fn reacts_somewhere(&self, row: usize, fault: usize) -> bool {
        0.0 < self.largest[(row, fault)]
    }

    /// Whether the fault reaches the residual channel at this frequency.
    pub(crate) fn reacts(&self, row: usize, fault: usize, omega: f64) -> bool {
        // On a pole of the plant the response to the fault is unbounded unless it cancels, which
        // the neighbourhood decides.
        let Some((hy, g)) = self.factors(omega) else { return self.reacts_somewhere(row, fault) };
        let (gain, scale) = entry(&hy, &g, row, fault);
        ZERO * scale.max(self.largest[(row, fault)]) < gain
    }

    fn factors(&self, omega: f64) -> Option<(Mat<c64>, Mat<c64>)> {
        if !is_clear(self.gf.domain(), &self.poles, omega) {
            return None;
        }
        let (_, hy) = self.form.response(omega).ok()?;
        Some((hy, self.gf.frequency_response(omega).ok()?))
    }
}

/// The gain from a fault to a residual channel, and the product of norms that bounds it.
fn entry(hy: &Mat<c64>, g: &Mat<c64>, row: usize, fault: usize) -> (f64, f64) {
    let (h, g) = (hy.row(row), g.col(fault));
    ((h * g).norm(), h.norm_l2() * g.norm_l2())
}
