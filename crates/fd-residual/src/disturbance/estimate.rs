//! Estimating the disturbance on every state in healthy logs.

use faer::{Mat, Scale, c64};
use fd_core::{Shape, ShapeError};
use fd_model::{Discrete, ModelError, Record, StateSpace, TimeDomain, riccati};
use fd_numeric::dense::DenseReal;

use crate::{error::DesignError, matrix::blocks};

/// What is known of the disturbances before any log is seen.
///
/// Each state has a disturbance `d⁺ = ρ d + w` with `ρ = exp(−Ts/duration_s)` and a standard
/// deviation of one, and each output has white noise with standard deviation `output_noise` in
/// the same (scaled) units per sample. Where the outputs cannot tell two states apart, the
/// estimate with least energy is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expectation {
    /// Time over which a disturbance changes, in s.
    pub duration_s: f64,
    /// Standard deviation of the output noise over that of the disturbances per sample.
    pub output_noise: f64,
    /// Samples at the start of each log that are not used; at least five time constants of the
    /// filter never are, so that it has forgotten where the log began.
    pub settle: usize,
}

/// Mean of `d̂ d̂ᵀ` over all complete samples.
pub(super) fn second_moment(
    model: &StateSpace<Discrete>,
    records: &[Record],
    expected: &Expectation,
) -> Result<Mat<f64>, DesignError> {
    let (n, ny) = (model.nx(), model.ny());
    let filter = Filter::new(model, expected)?;
    let settle = expected.settle.max(filter.settling()?);
    let mut moment = Mat::<f64>::zeros(n, n);
    let mut count = 0_u32;
    for record in records {
        check_record(model, record)?;
        let mut z = Mat::<f64>::zeros(2 * n, 1);
        for k in 0..record.len() {
            let complete = record.is_complete(k);
            let column = |values: &[f64]| {
                Mat::from_fn(values.len(), 1, |i, _| if complete { values[i] } else { 0.0 })
            };
            let (u, y) = (column(record.u(k)), column(record.y(k)));
            // Without a sample the filter predicts.
            let innovation =
                if complete { y - &filter.c * &z - model.d() * &u } else { Mat::zeros(ny, 1) };
            if complete && settle <= k {
                let d = z.subrows(n, n) + &filter.correct * &innovation;
                moment += &d * d.transpose();
                count += 1;
            }
            z = &filter.a * &z + &filter.b * &u + &filter.gain * innovation;
        }
    }
    if count == 0 {
        return Err(DesignError::Empty { what: "complete sample after settling" });
    }
    Ok(Scale(f64::from(count).recip()) * moment)
}

/// Stationary Kalman filter for `[x; d]`.
struct Filter {
    a: Mat<f64>,
    b: Mat<f64>,
    c: Mat<f64>,
    gain: Mat<f64>,
    /// From the innovation to the correction of `d` at the same sample.
    correct: Mat<f64>,
}

impl Filter {
    fn new(model: &StateSpace<Discrete>, expected: &Expectation) -> Result<Self, DesignError> {
        let (n, nu, ny) = (model.nx(), model.nu(), model.ny());
        let positive = |v: f64| 0.0 < v && v.is_finite();
        for value in [expected.duration_s, expected.output_noise] {
            if !positive(value) {
                return Err(DesignError::Speed { factor: value });
            }
        }
        let rho = (-model.domain().ts.seconds() / expected.duration_s).exp();
        let keep = Scale(rho) * Mat::<f64>::identity(n, n);
        let (none, one) = (Mat::<f64>::zeros(n, n), Mat::<f64>::identity(n, n));
        let a = blocks(&[&[model.a(), one.as_ref()], &[none.as_ref(), keep.as_ref()]]);
        let b = blocks(&[&[model.b()], &[Mat::zeros(n, nu).as_ref()]]);
        let c = blocks(&[&[model.c(), Mat::zeros(ny, n).as_ref()]]);
        let drive = 1.0 - rho * rho;
        let q = Mat::from_fn(2 * n, 2 * n, |i, j| if i == j && n <= i { drive } else { 0.0 });
        let noise = expected.output_noise.powi(2);
        let r = Mat::from_fn(ny, ny, |i, j| if i == j { noise } else { 0.0 });
        let found = riccati::discrete_filter(a.as_ref(), c.as_ref(), q.as_ref(), r.as_ref())?;
        // The predictor gain of d is ρ times its correction.
        let correct = Scale(rho.recip()) * found.gain.subrows(n, n).to_owned();
        Ok(Self { a, b, c, gain: found.gain, correct })
    }

    /// Samples after which e⁻⁵ of the initial error is left, by the slowest mode.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    fn settling(&self) -> Result<usize, DesignError> {
        let closed = &self.a - &self.gain * &self.c;
        let failed = ModelError::NoConvergence { what: "eigenvalues", order: closed.nrows() };
        let modes = closed.modes().map_err(|_| failed)?;
        let slowest = modes.iter().map(|p: &c64| p.norm()).fold(0.0, f64::max);
        Ok(if 0.0 < slowest { (-5.0 / slowest.ln()).ceil() as usize } else { 0 })
    }
}

pub(super) fn check_record(
    model: &StateSpace<Discrete>,
    record: &Record,
) -> Result<(), DesignError> {
    model.domain().join(Discrete { ts: record.ts() })?;
    let (expected, found) = (
        Shape::new(model.ny(), model.nu()),
        Shape::new(record.outputs().len(), record.inputs().len()),
    );
    if expected != found {
        return Err(ShapeError { role: "channels of a healthy log", expected, found }.into());
    }
    Ok(())
}
