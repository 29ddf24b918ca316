//! How far an effect moves the outputs once the nuisances have done what they can, to first order.

use fd_numeric::dot;

use super::{
    error::BlindError,
    truth::{Effect, Scene},
};

/// Step of a nuisance, in its standard deviations.
const STEP: f64 = 0.05;
/// Standard deviation of a nuisance in tolerances, as a diagnosis takes it.
const PRIOR: f64 = 0.67;
/// Half width of the box of a nuisance, in its standard deviations.
const BOX: f64 = 2.0 / PRIOR;
/// Sweeps over the nuisances.
const SWEEPS: usize = 300;
/// Halvings of the interval in which a strength is sought.
const HALVINGS: usize = 8;

/// A noise-free run without effects, and how it changes with the nuisances.
pub(super) struct Yardstick<'a> {
    scene: &'a Scene<'a>,
    x0: Vec<f64>,
    base: Vec<f64>,
    slopes: Vec<Vec<f64>>,
    /// `I + JᵀJ`: the prior, and the slopes in units of the noise.
    normal: Vec<Vec<f64>>,
    sigma: Vec<f64>,
}

impl<'a> Yardstick<'a> {
    /// `None` when the plant diverges without any effect.
    pub(super) fn new(scene: &'a Scene<'a>) -> Result<Option<Self>, BlindError> {
        let (truth, model) = (scene.truth, scene.model);
        let x0 = scene.initial(0);
        let sigma: Vec<f64> = model.outputs.iter().map(|o| o.noise.unwrap_or(1.0)).collect();
        let Some(base) = scene.outputs(&[], &truth.parameters, &x0, 0, false)? else {
            return Ok(None);
        };
        let mut slopes = Vec::new();
        let mut slope = |parameters: &[f64], x0: &[f64]| -> Result<(), BlindError> {
            if let Some(y) = scene.outputs(&[], parameters, x0, 0, false)? {
                let weigh = |(k, (y, base)): (usize, (&f64, &f64))| {
                    (y - base) / (STEP * sigma[k % sigma.len()])
                };
                slopes.push(y.iter().zip(&base).enumerate().map(weigh).collect::<Vec<f64>>());
            }
            Ok(())
        };
        for (i, parameter) in model.parameters.iter().enumerate() {
            if 0.0 < parameter.tolerance {
                let mut moved = truth.parameters.clone();
                moved[i] += STEP * PRIOR * parameter.tolerance * parameter.value.abs();
                slope(&moved, &x0)?;
            }
        }
        for (i, state) in model.states.iter().enumerate() {
            if let Some(tolerance) = state.tolerance.filter(|tolerance| 0.0 < *tolerance) {
                let mut moved = x0.clone();
                moved[i] += STEP * PRIOR * tolerance;
                slope(&truth.parameters, &moved)?;
            }
        }
        let entry =
            |i: usize, j: usize| dot(&slopes[i], &slopes[j]) + if i == j { 1.0 } else { 0.0 };
        let n = slopes.len();
        let normal = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
        Ok(Some(Self { scene, x0, base, slopes, normal, sigma }))
    }

    /// Squares of the noise that an effect leaves; infinite when the simulation diverges.
    pub(super) fn distance(&self, effect: &Effect) -> Result<f64, BlindError> {
        let (scene, one) = (self.scene, std::slice::from_ref(effect));
        let y = scene.outputs(one, &scene.truth.parameters, &self.x0, 0, false)?;
        let Some(y) = y else { return Ok(f64::INFINITY) };
        let ny = self.sigma.len();
        let pairs = y.iter().zip(&self.base).enumerate();
        let d: Vec<f64> = pairs.map(|(k, (y, base))| (y - base) / self.sigma[k % ny]).collect();
        let b: Vec<f64> = self.slopes.iter().map(|slope| dot(slope, &d)).collect();
        // Least |d − J z|² + |z|² in the box, coordinate by coordinate.
        let mut z = vec![0.0_f64; b.len()];
        for _ in 0..SWEEPS {
            for i in 0..z.len() {
                let row = &self.normal[i];
                let free = b[i] - dot(row, &z) + row[i] * z[i];
                z[i] = (free / row[i]).clamp(-BOX, BOX);
            }
        }
        let bent: f64 = self.normal.iter().zip(&z).map(|(row, z_i)| z_i * dot(row, &z)).sum();
        Ok((dot(&d, &d) - 2.0 * dot(&b, &z) + bent).max(0.0))
    }
}

/// Sets the strength of an effect so that it leaves about so many squares of the noise, within
/// the range of the law.
pub(super) fn seek(
    effect: &mut Effect,
    target: f64,
    [low, high]: [f64; 2],
    distance: &dyn Fn(&Effect) -> Result<f64, BlindError>,
) -> Result<(), BlindError> {
    let (mut low, mut high) = (low.ln(), high.ln());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        effect.strength = middle.exp();
        effect.distance = distance(effect)?;
        if effect.distance < target {
            low = middle;
        } else {
            high = middle;
        }
        if (effect.distance / target).ln().abs() < 0.2 {
            break;
        }
    }
    // The last one tried may be the first that diverges.
    while !effect.distance.is_finite() && 1e-9 < effect.strength {
        effect.strength *= 0.7;
        effect.distance = distance(effect)?;
    }
    Ok(())
}
