//! Periodic force.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::each_site;
use crate::{Effect, InAnotherRun, Offers};

/// Frequencies of the coarse grid from which to start.
const FREQUENCIES: u8 = 6;

/// A force of unknown frequency `w` in Hz: a sinusoid `a sin(2π w t) + b cos(2π w t)`, or a square
/// wave, `A tanh(k s/A)/tanh(k)` of such a sinusoid `s` with amplitude `A`.
#[derive(Clone, Copy, Debug)]
pub struct PeriodicForce;

impl Effect for PeriodicForce {
    fn label(&self) -> &'static str {
        "periodic-force"
    }

    fn family(&self) -> &'static str {
        "load"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let (lowest, highest) = (0.5 / scales.duration, 0.45 / scales.ts);
        // In periods per log. A square wave above an eighth of the sample rate is all but a
        // sinusoid.
        let bounds = |highest: f64| [0.5, highest * scales.duration];
        let grid: Vec<f64> = (0..FREQUENCIES)
            .map(|i| (f64::from(i) + 0.5) / f64::from(FREQUENCIES))
            .map(|x| 0.5 * (highest / lowest).powf(x))
            .collect();
        each_site(self, nominal, scales, |sketch, at| {
            let wave = |law, highest| {
                sketch(law)
                    .strength("a", "sine", &at.site.unit, at.force(), [-3.0, 3.0])
                    .strength("b", "cosine", &at.site.unit, at.force(), [-3.0, 3.0])
                    .shape("w", "frequency", "Hz", 1.0 / scales.duration, bounds(highest), grid[0])
                    .define("s", "wave", "a*sin(2*pi*w*t) + b*cos(2*pi*w*t)")
                    .spectral(2)
                    .in_another_run(InAnotherRun::Another)
            };
            let sinusoid = wave("sinusoid", highest).force("periodic_force", "s");
            let square = wave("square", 0.125 / scales.ts)
                .shape("k", "squareness", "1", 1.0, [0.1, 12.0], 0.1)
                .bind("F", 1e-9 * at.force())
                .abbreviate("A", "sqrt(a^2 + b^2 + F^2)")
                .force("periodic_force", "A*tanh(k*s/A)/tanh(k)");
            vec![
                grid.iter().fold(sinusoid, |sketch, w| sketch.start(&[0.1, 0.1, *w])),
                grid.iter().fold(square, |sketch, w| sketch.start(&[0.1, 0.1, *w, 5.0])),
            ]
        })
    }
}
