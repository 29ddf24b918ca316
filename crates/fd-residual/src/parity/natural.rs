//! Windows in natural units, and what a relative change of the data can do to them.

use faer::{Mat, MatRef, Scale, c64};
use fd_model::{StateSpace, TimeDomain};

use super::window::{input_map, observability};
use crate::{
    analysis::UnknownInputs,
    error::DesignError,
    matrix::{blocks, complex, orthonormal_rows},
    natural::Natural,
    rank::{Decided, RankDecision, RankTolerance, decide},
};

/// A plant with its unknown inputs, ready for windows of any length.
pub(crate) struct NaturalPlant(Natural);

impl NaturalPlant {
    pub(crate) fn of<D: TimeDomain>(
        model: &StateSpace<D>,
        unknown: &UnknownInputs,
    ) -> Result<Self, DesignError> {
        let mut natural = Natural::of(model, unknown)?;
        if model.domain().highest_frequency().is_finite() {
            // A shift has no unit, and vectors whose last sample is measured in millionths of the first
            // would be rounding in those of the model.
            let pace = Scale(natural.units.rate);
            (natural.a, natural.b) = (pace * &natural.a, pace * &natural.b);
            natural.units.rate = 1.0;
        }
        Ok(Self(natural))
    }

    pub(crate) fn rate(&self) -> f64 {
        self.0.units.rate
    }

    /// One unit of each output in natural units, in the units of the model.
    pub(crate) fn output_units(&self) -> &[f64] {
        &self.0.units.outputs
    }

    /// What a window of `order + 1` samples sees.
    pub(crate) fn window(&self, order: usize) -> NaturalWindow {
        let (a, c) = (self.0.a.as_ref(), self.0.c.as_ref());
        let entry = |j: usize| (self.0.b.subcols(j, 1), self.0.d.subcols(j, 1));
        let sizes = Sizes::of(a, c, order);
        let inputs = (0..self.0.b.ncols()).map(|j| {
            let (b, d) = entry(j);
            let map = input_map(a, b, c, d, order);
            InputMap { scale: sizes.of_map(a, b, d), norm: map.norm_l2(), map }
        });
        NaturalWindow {
            gamma: observability(a, c, order),
            gamma_scale: sizes.of_gamma(),
            inputs: inputs.collect(),
        }
    }

    /// Orthonormal vectors for samples in the units of the model, with the span of these.
    pub(crate) fn in_model_units(&self, w: MatRef<'_, f64>) -> Mat<f64> {
        let (ny, rate) = (self.0.c.nrows(), self.0.units.rate);
        let factor = |j: usize| {
            let sample = i32::try_from(j / ny).unwrap_or(i32::MAX);
            (self.0.units.outputs[j % ny] * rate.powi(sample)).recip()
        };
        orthonormal_rows(&Mat::from_fn(w.nrows(), w.ncols(), |i, j| w[(i, j)] * factor(j)))
    }
}

/// Norms of `c_i Aᵏ` and `Aᵏ` for all lags of a window.
struct Sizes {
    rows: Vec<Vec<f64>>,
    powers: Vec<f64>,
    a: f64,
}

impl Sizes {
    fn of(a: MatRef<'_, f64>, c: MatRef<'_, f64>, order: usize) -> Self {
        let (mut ca, mut power) = (c.to_owned(), Mat::<f64>::identity(a.nrows(), a.nrows()));
        let (mut rows, mut powers) = (Vec::new(), Vec::new());
        for lag in 0..=order {
            rows.push((0..c.nrows()).map(|i| ca.row(i).norm_l2()).collect());
            powers.push(if lag == 0 { 1.0 } else { power.norm_l2() });
            (ca, power) = (&ca * a, &power * a);
        }
        Self { rows, powers, a: a.norm_l2() }
    }

    /// `‖δΓ‖ / ε` for changes of `C` and `A` by `ε`: `δ(c Aᵏ) = δc Aᵏ + Σ c Aᵏ⁻ˡ δA Aˡ⁻¹`.
    fn of_gamma(&self) -> f64 {
        let moved = |i: usize, lag: usize| {
            let by_a = (1..=lag).map(|l| self.rows[lag - l][i] * self.powers[l - 1]);
            self.rows[0][i] * self.powers[lag] + self.a * by_a.sum::<f64>()
        };
        let (ny, lags) = (self.rows[0].len(), self.rows.len());
        let squares = (0..lags).flat_map(|lag| (0..ny).map(move |i| (i, lag)));
        squares.map(|(i, lag)| moved(i, lag).powi(2)).sum::<f64>().sqrt()
    }

    /// `‖δT‖ / ε` for changes of `A`, `B`, `C` and `D` by `ε` of their size:
    /// `δ(c Aᵏ⁻¹ b) = δc Aᵏ⁻¹ b + c Aᵏ⁻¹ δb + Σ c Aᵏ⁻¹⁻ˡ δA Aˡ⁻¹ b`.
    fn of_map(&self, a: MatRef<'_, f64>, b: MatRef<'_, f64>, d: MatRef<'_, f64>) -> f64 {
        let (ny, lags) = (self.rows[0].len(), self.rows.len());
        let mut columns = Vec::with_capacity(lags);
        let mut ab = b.to_owned();
        for _ in 0..lags {
            columns.push(ab.norm_l2());
            ab = a * ab;
        }
        let direct = d.norm_l2();
        let moved = |i: usize, lag: usize| {
            if lag == 0 {
                return direct;
            }
            let k = lag - 1;
            let by_a = (1..=k).map(|l| self.rows[k - l][i] * columns[l - 1]);
            self.rows[0][i] * columns[k] + self.rows[k][i] * columns[0] + self.a * by_a.sum::<f64>()
        };
        // Lag k appears in as many columns of the window as there are samples after it.
        let of_lag = |lag: usize| {
            let squares = (0..ny).map(|i| moved(i, lag).powi(2)).sum::<f64>();
            (lags - lag) as f64 * squares
        };
        (0..lags).map(of_lag).sum::<f64>().sqrt()
    }
}

/// What an unknown input does to a window.
pub(crate) struct InputMap {
    map: Mat<f64>,
    /// By how much a relative change of the data of size one moves it.
    scale: f64,
    norm: f64,
}

/// `Γ` and the map of each unknown input.
pub(crate) struct NaturalWindow {
    gamma: Mat<f64>,
    gamma_scale: f64,
    inputs: Vec<InputMap>,
}

impl NaturalWindow {
    /// Vectors that annihilate the state and these unknown inputs.
    pub(crate) fn decoupled_from(
        &self,
        ignored: &[usize],
        tolerance: RankTolerance,
    ) -> Result<Decided, DesignError> {
        let mut row = vec![self.gamma.as_ref()];
        row.extend(ignored.iter().map(|&j| self.inputs[j].map.as_ref()));
        let squares = ignored.iter().map(|&j| self.inputs[j].scale.powi(2)).sum::<f64>();
        decide(blocks(&[&row]).as_ref(), squares.sqrt().hypot(self.gamma_scale), tolerance)
    }

    /// What these vectors make of an unknown input, relative to what a change of the data could: of the
    /// input's own map, and of the vectors, which move by the reciprocal of the smallest value `kept` in
    /// their decision.
    pub(crate) fn reaction(
        &self,
        w: MatRef<'_, f64>,
        input: usize,
        kept: &RankDecision,
    ) -> Mat<f64> {
        let InputMap { map, scale, norm } = &self.inputs[input];
        let turned = if kept.rank == 0 { 0.0 } else { norm / kept.smallest_kept };
        let moved = scale + turned;
        let moved = if 0.0 < moved { moved } else { 1.0 };
        Scale(moved.recip()) * (w * map)
    }

    /// Whether there is any, at each point of the frequency axis too.
    pub(crate) fn reacts(
        reaction: MatRef<'_, f64>,
        waves: &[Mat<c64>],
        tolerance: RankTolerance,
    ) -> RankDecision {
        let sum = reaction.norm_l2();
        // A fault that grows like pᵏ gives the residual W T [1; p; …; pˢ] pᵏ.
        let at = waves.iter().map(|wave| (complex(reaction) * wave).norm_l2());
        RankDecision::of(1, &[at.fold(sum, f64::min)], tolerance)
    }
}
