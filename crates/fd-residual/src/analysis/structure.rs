//! Which residual reacts to which fault.

use faer::{Mat, MatRef, c64, prelude::Solve};
use fd_model::{StateSpace, TimeDomain};
use fd_numeric::dense::Dense;

use super::signature::Signature;
use crate::{
    error::DesignError,
    form::{ResidualForm, frequency_grid, is_clear},
    matrix::{complex, with_natural_states},
};

/// Gains below this fraction of what the terms they are summed from would give without cancellation
/// count as zero.
const ZERO: f64 = 1e-9;

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

/// Decides whether `|[H_y]_row [G_f]_fault|` is zero, against the sum of the sizes of all its terms, down
/// to the entries of the matrices: what is nothing but rounding is small next to it in any units.
pub(crate) struct Visibility<D> {
    hy: StateSpace<D>,
    gf: StateSpace<D>,
    /// Natural units of the outputs.
    units: Vec<f64>,
    poles: Vec<c64>,
    /// Largest entry of each pair over the grid, where it stands out from rounding.
    largest: Mat<f64>,
}

impl<D: TimeDomain> Visibility<D> {
    pub(crate) fn of(form: &ResidualForm<D>, gf: &StateSpace<D>) -> Result<Self, DesignError> {
        // Also checks that the two fit.
        form.residual_of(gf)?;
        let grid = frequency_grid(&[form.system(), gf])?;
        let mut largest = Mat::zeros(form.residual_len(), gf.nu());
        let mut poles = form.system().poles()?;
        poles.extend(gf.poles()?);
        let mut visibility = Self {
            hy: with_natural_states(&form.hy()?)?,
            gf: with_natural_states(gf)?,
            units: gf.natural_units().outputs,
            poles,
            largest: largest.clone(),
        };
        for omega in grid {
            let Some(pairs) = visibility.pairs(omega) else { continue };
            for row in 0..largest.nrows() {
                for fault in 0..largest.ncols() {
                    let (gain, scale) = pairs.of(row, fault);
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
        let Some(pairs) = self.pairs(omega) else { return self.reacts_somewhere(row, fault) };
        let (gain, scale) = pairs.of(row, fault);
        ZERO * scale.max(self.largest[(row, fault)]) < gain
    }

    fn pairs(&self, omega: f64) -> Option<Pairs<'_>> {
        if !is_clear(self.gf.domain(), &self.poles, omega) {
            return None;
        }
        let (hy, gf) = (Response::of(&self.hy, omega)?, Response::of(&self.gf, omega)?);
        Some(Pairs { hy, gf, units: &self.units })
    }
}

/// A frequency response, and what it would be if nothing cancelled: `|C| |(p I − A)⁻¹| |B| + |D|`.
struct Response {
    gain: Mat<c64>,
    terms: Mat<f64>,
}

impl Response {
    fn of<D: TimeDomain>(system: &StateSpace<D>, omega: f64) -> Option<Self> {
        let (n, point) = (system.nx(), system.domain().point(omega));
        let pencil = Mat::from_fn(n, n, |i, j| {
            let a = c64::new(system.a()[(i, j)], 0.0);
            if i == j { point - a } else { -a }
        });
        let resolvent = pencil.lu().solve(Mat::<c64>::identity(n, n));
        let size = |m: MatRef<'_, f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)].abs());
        let (b, c, d) = (system.b(), system.c(), system.d());
        let sizes = Mat::from_fn(n, n, |i, j| resolvent[(i, j)].norm());
        let terms = size(c) * sizes * size(b) + size(d);
        let gain = complex(c) * (resolvent * complex(b)) + complex(d);
        let finite = (0..terms.ncols()).all(|j| terms.col(j).iter().all(|term| term.is_finite()));
        finite.then_some(Self { gain, terms })
    }
}

/// Both factors at one frequency.
struct Pairs<'a> {
    hy: Response,
    gf: Response,
    /// Natural units of the outputs between them.
    units: &'a [f64],
}

impl Pairs<'_> {
    /// The gain from a fault to a residual channel, and the sum of its terms.
    fn of(&self, row: usize, fault: usize) -> (f64, f64) {
        let gain = (self.hy.gain.row(row) * self.gf.gain.col(fault)).norm();
        let of = |scale: f64, term: f64| (term * scale).powi(2);
        let units = self.units.iter().enumerate();
        let (h, g) = units.fold((0.0, 0.0), |(h, g), (i, unit)| {
            let (through, into) = (self.hy.terms[(row, i)], self.gf.terms[(i, fault)]);
            (h + of(*unit, through), g + of(unit.recip(), into))
        });
        // At least the sum of the terms (Cauchy and Schwarz): an entry of H_y may be rounding next to
        // the others of its row.
        (gain, (h * g).sqrt())
    }
}
