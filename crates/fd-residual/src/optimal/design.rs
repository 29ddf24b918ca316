//! Factorising the noise.

use faer::{Mat, MatRef};
use fd_model::{Discrete, ModelError, StateSpace, TimeDomain};
use fd_numeric::dense::Dense;

use super::infinity::regular;
use crate::{
    analysis::{UnknownInputs, fault_effects, weak_structure},
    decouple::{LeftNullSpace, refuse_what_passes},
    error::DesignError,
    form::{ResidualForm, design_by_part, frequency_grid, peak_gain},
    kalman::{Noises, filter},
    matrix::blocks,
    observer::ErrorPoles,
    rank::RankDecision,
    simulation::check_stable,
};

/// Relative singular values below this count as zero.
const RANK: f64 = 1e-9;

/// By how much the gain of whitened noise may be above one: what norms and Riccati equations leave.
const AMPLIFIED: f64 = 1e-3;

/// Part of the residual's own gain with which noise may enter the quiet channels.
const LEAKED: f64 = 1e-6;

/// What a plant is exposed to, besides its known inputs.
#[derive(Clone, Debug)]
pub struct Exposure<'a> {
    /// Faults that the residual has to show.
    pub faults: &'a UnknownInputs,
    /// Disturbances that it must not show at all.
    pub disturbances: &'a UnknownInputs,
    /// White noise of unit intensity that it may show as little as possible.
    pub noise: &'a UnknownInputs,
}

/// An `H₋/H∞` optimal residual; runs as [`FormGenerator`](crate::form::FormGenerator).
///
/// The first [`noisy`](Self::noisy) channels have white noise of unit gain, the others none.
#[derive(Clone, Debug)]
pub struct OptimalDesign<D = Discrete> {
    form: ResidualForm<D>,
    noisy: usize,
}

impl<D: TimeDomain> OptimalDesign<D> {
    /// The optimal residual; residuals without noise die out at least at `rate` (1/s), which is
    /// also the corner `a` of noise without feedthrough.
    ///
    /// # Errors
    ///
    /// Returns [`DesignError::Undetectable`] or [`DesignError::NothingLeft`] when there is no
    /// solution, an error when the noise has a zero on the frequency axis, and
    /// [`DesignError::NotDecoupled`] or [`DesignError::NotWhitened`] when the residual, looked at again, is not
    /// what it should be.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::{
    ///     analysis::{UnknownInputs, fault_to_noise_gap},
    ///     optimal::{Exposure, OptimalDesign},
    /// };
    ///
    /// // x' = −x + u + f + w, y = x + v with |v| = |w|: the filter has the pole −√2.
    /// let plant = StateSpace::new(mat![[-1.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// let none = UnknownInputs::none(&plant);
    /// let faults = none.clone().actuator(&plant, 0)?;
    /// let noise = faults.clone().sensor(&plant, 0)?;
    /// let exposure = Exposure { faults: &faults, disturbances: &none, noise: &noise };
    /// let design = OptimalDesign::new(&plant, &exposure, 1.0)?;
    /// let pole = design.form().system().poles()?[0];
    /// assert!((pole.re + 2.0_f64.sqrt()).abs() < 1e-14);
    /// let gap = fault_to_noise_gap(design.form(), &faults.system(&plant)?, &noise.system(&plant)?)?;
    /// assert!((gap.noise.norm - 1.0).abs() < 1e-7);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(
        model: &StateSpace<D>,
        exposure: &Exposure<'_>,
        rate: f64,
    ) -> Result<Self, DesignError> {
        Self::placed(model, exposure, rate, &ErrorPoles::Rate(rate))
    }

    /// The optimal residual with the poles of the residuals without noise as given: nothing but
    /// the wish of the designer fixes them.
    ///
    /// # Errors
    ///
    /// As [`OptimalDesign::new`], and as [`LeftNullSpace::placed`] for the given poles.
    ///
    /// # Examples
    ///
    /// The first of two lags has noise on its sensor, the second has none; its residual, with the pole
    /// −5 where the plant has −2:
    ///
    /// ```
    /// use faer::{Mat, c64, mat};
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::{
    ///     analysis::UnknownInputs,
    ///     observer::ErrorPoles,
    ///     optimal::{Exposure, OptimalDesign},
    /// };
    ///
    /// let (a, b) = (mat![[-1.0, 0.0], [0.0, -2.0]], mat![[1.0], [1.0]]);
    /// let plant = StateSpace::new(a, b, Mat::identity(2, 2), Mat::zeros(2, 1), Continuous)?;
    /// let none = UnknownInputs::none(&plant);
    /// let noise = none.clone().sensor(&plant, 0)?;
    /// let faults = noise.clone().sensor(&plant, 1)?;
    /// let exposure = Exposure { faults: &faults, disturbances: &none, noise: &noise };
    /// let poles = ErrorPoles::Given(vec![c64::new(-5.0, 0.0)]);
    /// let design = OptimalDesign::placed(&plant, &exposure, 1.0, &poles)?;
    /// let found = design.form().system().poles()?;
    /// assert!(found.iter().any(|pole| (pole.re + 5.0).abs() < 1e-12));
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn placed(
        model: &StateSpace<D>,
        exposure: &Exposure<'_>,
        rate: f64,
        quiet: &ErrorPoles,
    ) -> Result<Self, DesignError> {
        let space = LeftNullSpace::of(model, exposure.disturbances)?;
        space.require(exposure.faults)?;
        let quiet = match LeftNullSpace::of(model, &exposure.disturbances.and(exposure.noise)?) {
            Err(DesignError::NothingLeft { .. }) => None,
            space => Some(space?.placed(quiet)?),
        };
        // Rows beyond the normal rank of the noise are those of the quiet residual.
        let rank = space.residual_len() - quiet.as_ref().map_or(0, ResidualForm::residual_len);
        let white = match rank {
            0 => None,
            rank => Some(whitened(&space, exposure.noise, rank, rate)?),
        };
        let form = match (white, quiet) {
            (Some(white), Some(quiet)) => {
                let gf = exposure.faults.system(model)?;
                beside(&white, &level(quiet, &white, &gf)?)?
            }
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => {
                let (inputs, outputs) = (exposure.disturbances.len(), model.ny());
                return Err(DesignError::NothingLeft { inputs, outputs });
            }
        };
        check_stable("an optimal residual", form.system())?;
        let design = Self { form, noisy: rank };
        design.verify(model, exposure, space.nearest())?;
        Ok(design)
    }

    /// Looks at the residual again: no disturbance passes, every fault reacts, the noise has unit gain in the
    /// noisy channels (in continuous time up to the corner of a low-pass) and none in the others.
    fn verify(
        &self,
        model: &StateSpace<D>,
        exposure: &Exposure<'_>,
        nearest: RankDecision,
    ) -> Result<(), DesignError> {
        let Exposure { faults, disturbances, noise } = exposure;
        refuse_what_passes(&self.form, disturbances, &disturbances.system(model)?, 0, nearest)?;
        let rows = weak_structure(&self.form, &faults.system(model)?)?;
        let unseen = |fault: &usize| rows.iter().all(|row| !row.0[*fault]);
        if let Some(fault) = (0..faults.len()).find(unseen) {
            let (fault, residuals) = (faults.names()[fault].clone(), rows.len());
            return Err(DesignError::Undetectable { fault, residuals });
        }
        let all = self.form.residual_of(&noise.system(model)?)?;
        let inputs: Vec<_> = (0..all.nu()).collect();
        let gain = |rows: std::ops::Range<usize>| {
            let rows: Vec<_> = rows.collect();
            Ok::<_, DesignError>(peak_gain(&all.select(&rows, &inputs)?)?.norm)
        };
        let (loud, quiet) = (gain(0..self.noisy)?, gain(self.noisy..all.ny())?);
        let size = peak_gain(self.form.system())?.norm;
        // No channels have no gain.
        if 1.0 + AMPLIFIED < loud || LEAKED * size < quiet {
            return Err(DesignError::NotWhitened { loud, quiet });
        }
        Ok(())
    }

    /// The transfer functions from `u` and `y` to the residual.
    #[must_use]
    pub fn form(&self) -> &ResidualForm<D> {
        &self.form
    }

    /// Number of channels that have noise; they come first.
    #[must_use]
    pub fn noisy(&self) -> usize {
        self.noisy
    }
}

design_by_part!(OptimalDesign<Discrete>, form);

/// `R_o⁻¹ Q₁` for `rank` combinations of the residuals in which the noise has full rank.
fn whitened<D: TimeDomain>(
    space: &LeftNullSpace<D>,
    noise: &UnknownInputs,
    rank: usize,
    rate: f64,
) -> Result<ResidualForm<D>, DesignError> {
    let noisy = space.seen(noise)?;
    let space = if rank == noisy.ny() {
        space.clone()
    } else {
        space.combined(loudest(&noisy, rank)?.as_ref())?
    };
    let seen = space.seen(noise)?;
    if regular(&seen, rate)?.filters.is_empty() {
        // One filter for the state and the noise.
        let (gain, scale) = innovations(&seen)?;
        return space.with_gain(gain.as_ref())?.weighted(scale.as_ref());
    }
    // First any stable residual, then the inverse of the noise in it.
    let first = space.placed(&ErrorPoles::Rate(rate))?;
    let found = regular(&first.residual_of(&noise.system(space.model())?)?, rate)?;
    let (gain, scale) = innovations(&found.system)?;
    let s = &found.system;
    let inverse =
        StateSpace::new(s.a() - &gain * s.c(), gain, -(&scale * s.c()), scale, s.domain())?;
    let mut system = first.system().clone();
    for filter in &found.filters {
        system = system.series(filter)?;
    }
    ResidualForm::new(first.io(), system.series(&inverse)?)
}

/// Gain of the Kalman filter for the noise `s` makes, and the inverse root of the covariance of
/// its innovations.
fn innovations<D: TimeDomain>(s: &StateSpace<D>) -> Result<(Mat<f64>, Mat<f64>), DesignError> {
    let noises = Noises {
        q: s.b() * s.b().transpose(),
        s: s.b() * s.d().transpose(),
        r: s.d() * s.d().transpose(),
    };
    let found = filter(s.domain(), s.a(), s.c(), &noises)?;
    let order = s.ny();
    let failed = ModelError::NoConvergence { what: "covariance of the innovations", order };
    let eigen = found.innovation.symmetric_eigen().map_err(|_| failed)?;
    let (u, values) = (eigen.U(), eigen.S().column_vector());
    let scaled = Mat::from_fn(order, order, |i, j| u[(i, j)] / values[j].sqrt());
    Ok((found.gain, scaled * u.transpose()))
}

/// Orthonormal combinations of the outputs in which the noise is largest over frequency.
pub(crate) fn loudest<D: TimeDomain>(
    noise: &StateSpace<D>,
    rank: usize,
) -> Result<Mat<f64>, DesignError> {
    let mut all = Mat::<f64>::zeros(noise.ny(), 0);
    for omega in frequency_grid(&[noise])? {
        let Ok(g) = noise.frequency_response(omega) else { continue };
        let size = g.norm_l2();
        if 0.0 < size {
            let part = |f: fn(faer::c64) -> f64| {
                Mat::from_fn(g.nrows(), g.ncols(), |i, j| f(g[(i, j)]) / size)
            };
            all = blocks(&[&[all.as_ref(), part(|v| v.re).as_ref(), part(|v| v.im).as_ref()]]);
        }
    }
    let failed = ModelError::NoConvergence { what: "directions of the noise", order: noise.nx() };
    let svd = all.full_svd().map_err(|_| failed)?;
    let sigma = svd.S().column_vector();
    let clear = sigma.iter().filter(|&&s| RANK * sigma[0] < s).count();
    if clear < rank {
        return Err(ModelError::Singular { role: "noise filter G_w" }.into());
    }
    Ok(svd.U().subcols(0, rank).transpose().to_owned())
}

/// The quiet residual, as loud for its weakest fault as the other one is for its strongest.
fn level<D: TimeDomain>(
    quiet: ResidualForm<D>,
    white: &ResidualForm<D>,
    gf: &StateSpace<D>,
) -> Result<ResidualForm<D>, DesignError> {
    let peaks = |form: &ResidualForm<D>| -> Result<Vec<f64>, DesignError> {
        let effects = fault_effects(form, gf)?.into_iter();
        Ok(effects.filter(|e| e.detectable).map(|e| e.peak.norm).collect())
    };
    let strongest = peaks(white)?.into_iter().fold(0.0, f64::max);
    let weakest = peaks(&quiet)?.into_iter().fold(f64::INFINITY, f64::min);
    let gain = strongest / weakest;
    if !(0.0 < gain && gain.is_finite()) {
        return Ok(quiet);
    }
    let rows = quiet.residual_len();
    quiet.weighted(Mat::from_fn(rows, rows, |i, j| if i == j { gain } else { 0.0 }).as_ref())
}

/// Two residuals of one plant, one above the other.
fn beside<D: TimeDomain>(
    first: &ResidualForm<D>,
    second: &ResidualForm<D>,
) -> Result<ResidualForm<D>, DesignError> {
    let both = first.system().append(second.system())?;
    let width = first.io().nu + first.io().ny;
    let copy = Mat::<f64>::identity(width, width);
    let copy: MatRef<'_, f64> = copy.as_ref();
    let spread = StateSpace::gain(blocks(&[&[copy], &[copy]]), both.domain())?;
    ResidualForm::new(first.io(), spread.series(&both)?)
}
