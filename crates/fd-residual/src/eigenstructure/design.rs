//! Choosing the weighting and the gain together.

use faer::{Mat, MatRef, c64};
use fd_core::{IoDims, Shape, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace, TimeDomain};

use crate::{
    decouple::refuse_what_enters,
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::{blocks, check_shape, orthonormal_rows, spectral_norm},
    natural::Natural,
    observer::{ErrorPoles, ObserverDesign, natural, place_visible, pole_of_rate},
    rank::{RankTolerance, decide},
};

/// An observer with a weighting whose rows are its own left eigenvectors.
#[derive(Clone, Debug)]
pub struct EigenstructureDesign<D = Discrete> {
    observer: ObserverDesign<D>,
    weight: Mat<f64>,
}

impl<D: TimeDomain> EigenstructureDesign<D> {
    /// All residual rows that can be decoupled from `E` (states × unknown inputs), each a left
    /// eigenvector; the rest of the observer gets the same kind of poles.
    ///
    /// With given poles, the first is that of the residual and the others belong to the rest.
    ///
    /// # Errors
    ///
    /// Returns [`DesignError::NoEigenvector`] when no row can be decoupled, the mode that does
    /// not decay when the rest cannot be stabilised, [`DesignError::NotDecoupled`] when a row,
    /// looked at again over frequency, lets an unknown input pass, or fails as
    /// [`place_poles`](crate::observer::place_poles) does.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{eigenstructure::EigenstructureDesign, observer::ErrorPoles};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let (a, b) = (mat![[0.9, 0.1], [0.2, 0.8]], mat![[1.0], [0.0]]);
    /// let model = StateSpace::new(a, b, Mat::identity(2, 2), Mat::zeros(2, 1), domain)?;
    /// let e = mat![[1.0], [1.0]];
    /// let design = EigenstructureDesign::new(&model, e.as_ref(), &ErrorPoles::DeadBeat)?;
    /// let weight = design.weight(); // y₁ − y₂, up to a factor
    /// assert!((weight[(0, 0)] + weight[(0, 1)]).abs() < 1e-15);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(
        model: &StateSpace<D>,
        e: MatRef<'_, f64>,
        poles: &ErrorPoles,
    ) -> Result<Self, DesignError> {
        let n = model.nx();
        check_shape("unknown input matrix E", e, Shape::new(n, e.ncols()))?;
        let given = e;
        let Natural { a, b: e, c, units, .. } = natural(model, e)?;
        let (c, rate) = (c.as_ref(), units.rate);
        let hidden = complement(c)?;
        let spread = blocks(&[&[(c * &e).as_ref(), (c * &a * &hidden).as_ref()]]);
        let scale = c.norm_l2() * a.norm_l2().hypot(e.norm_l2());
        let decided = decide(spread.as_ref(), scale, RankTolerance::default())?;
        let weight = decided.annihilators();
        if weight.nrows() == 0 {
            let (inputs, rank) = (e.ncols(), decided.decision.rank);
            return Err(DesignError::NoEigenvector { inputs, rank });
        }

        // The gain is found at the pace of the model.
        let a = faer::Scale(rate) * a;
        // V L = G makes the rows of V = W C (independent ones) left eigenvectors.
        let v = row_space((&weight * c).as_ref())?;
        let own = residual_pole(model.domain(), poles)?;
        let shifted = Mat::from_fn(n, n, |i, j| a[(i, j)] - if i == j { own } else { 0.0 });
        let g = solve_rows(c, (&v * shifted).as_ref())?;
        let on_rows = v.transpose() * g;

        // What is left of the observer lives on null(V) and is moved by L = Vᵀ G + N Z.
        let rest = complement(v.as_ref())?;
        let block = rest.transpose() * (&a - &on_rows * c) * &rest;
        let shown = c * &rest;
        let others = match poles {
            ErrorPoles::Given(all) => ErrorPoles::Given(all.iter().skip(1).copied().collect()),
            other => other.clone(),
        };
        let stuck =
            |mode: c64| DesignError::Unobservable { re: mode.re, im: mode.im, distance: 0.0 };
        let z = place_visible(model.domain(), block.as_ref(), shown.as_ref(), &others, stuck)?;
        let gain = on_rows + rest * z;
        let (x, y) = (&units.states, &units.outputs);
        let gain = Mat::from_fn(n, y.len(), |i, j| gain[(i, j)] * (x[i] / y[j]));
        let weight = Mat::from_fn(weight.nrows(), y.len(), |i, j| weight[(i, j)] / y[j]);
        let weight = orthonormal_rows(&weight);
        let design = Self { observer: ObserverDesign::with_gain(model, gain.as_ref())?, weight };
        refuse_what_enters(&design.form()?, model, given, decided.decision)?;
        Ok(design)
    }

    /// The weighting `W` (residuals × outputs), with orthonormal rows.
    #[must_use]
    pub fn weight(&self) -> MatRef<'_, f64> {
        self.weight.as_ref()
    }

    /// The observer in front of it.
    #[must_use]
    pub fn observer(&self) -> &ObserverDesign<D> {
        &self.observer
    }

    /// The transfer functions from `u` and `y` to the residual.
    ///
    /// # Errors
    ///
    /// Never fails for a checked design.
    pub fn form(&self) -> Result<ResidualForm<D>, DesignError> {
        self.observer.form()?.weighted(self.weight())
    }
}

impl GeneratorDesign for EigenstructureDesign<Discrete> {
    fn io(&self) -> IoDims {
        GeneratorDesign::io(&self.observer)
    }

    fn residual_len(&self) -> usize {
        self.weight.nrows()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        EigenstructureDesign::form(self)
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        crate::weighted::WeightedDesign::new(self.observer.clone(), self.weight())?.build()
    }
}

/// The one pole that all rows of the residual share.
fn residual_pole<D: TimeDomain>(domain: D, poles: &ErrorPoles) -> Result<f64, DesignError> {
    match poles {
        ErrorPoles::Rate(rate) => Ok(pole_of_rate(domain, *rate)?.re),
        ErrorPoles::DeadBeat => Ok(0.0),
        ErrorPoles::Given(all) => match all.first() {
            Some(pole) if pole.im.abs() < f64::MIN_POSITIVE => Ok(pole.re),
            Some(&c64 { re, im }) => Err(DesignError::PoleConjugate { re, im }),
            None => Err(DesignError::Empty { what: "pole" }),
        },
    }
}

/// Orthonormal columns that no row of `m` sees.
fn complement(m: MatRef<'_, f64>) -> Result<Mat<f64>, DesignError> {
    let decided = decide(m.transpose(), spectral_norm(m), RankTolerance::default())?;
    Ok(decided.annihilators().transpose().to_owned())
}

/// Orthonormal rows with the span of those of `m`.
fn row_space(m: MatRef<'_, f64>) -> Result<Mat<f64>, DesignError> {
    let rest = complement(m)?;
    complement(rest.transpose()).map(|columns| columns.transpose().to_owned())
}

/// `G` with `G C = M`, where the rows of `M` lie in the row space of `C`.
fn solve_rows(c: MatRef<'_, f64>, m: MatRef<'_, f64>) -> Result<Mat<f64>, DesignError> {
    // Not by `CᵀC`, which has the squared condition: the gain may be large.
    Ok(m * decide(c, spectral_norm(c), RankTolerance::default())?.pseudoinverse())
}
