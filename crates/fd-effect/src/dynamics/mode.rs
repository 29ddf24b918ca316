//! A resonance that the model lacks.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::each_site;
use crate::{Effect, Offers, Reason};

/// Shares of the mass from which to start, each with this many frequencies on a logarithmic grid. A small
/// share changes the run in proportion, so that its fine grid tells the frequency; a large one moves the
/// resonances that the model has.
const STARTS: [(f64, u8); 2] = [(0.01, 40), (0.1, 14)];
/// Damping ratio from which to start.
const DAMPING: f64 = 0.06;
/// Largest `h ω` of an integration step `h`: relative error of Runge-Kutta `(h ω)⁵/120 = 3e-3` per
/// step at the highest frequency.
const FASTEST: f64 = 0.8;

/// An appendage on a spring: a share `m` of the moving mass swings with frequency `f` (Hz) and
/// damping ratio `z`.
///
/// With `a` the acceleration of the nominal model, `r` the relative displacement and
/// `P = ω² r + 2 z ω r'`, the appendage obeys `r'' = -a - (1 + m) P` and accelerates what carries
/// it by `m P`. A run starts with `r = 0`.
#[derive(Clone, Copy, Debug)]
pub struct ResonantMode;

impl Effect for ResonantMode {
    fn label(&self) -> &'static str {
        "resonant-mode"
    }

    fn family(&self) -> &'static str {
        "resonance"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let lowest = 2.0 / scales.duration;
        let highest = (0.4 / scales.ts).min(FASTEST / (std::f64::consts::TAU * scales.step));
        let starts = STARTS.iter().flat_map(|(share, count)| {
            let middle = move |i: u8| (f64::from(i) + 0.5) / f64::from(*count);
            (0..*count).map(move |i| [*share, lowest * (highest / lowest).powf(middle(i)), DAMPING])
        });
        let starts: Vec<[f64; 3]> = starts.collect();
        each_site(self, nominal, scales, |sketch, at| {
            let mode = sketch("appendage")
                .with_velocity(at)
                .require(at.has_velocity(), Reason::Missing("velocity"))
                .require(at.site.has_equation(), super::sites::NO_EQUATION)
                .with_helpers(&at.site.helpers)
                .bind("a", at.site.acceleration.clone())
                .bind("C", at.site.compliance.clone())
                .strength("m", "mode_share", "1", 1.0, [0.0, 5.0])
                .shape("f", "mode_frequency", "Hz", 1.0, [lowest, highest], lowest)
                .shape("z", "mode_damping", "1", 1.0, [1e-3, 1.0], DAMPING)
                .abbreviate("w", "2*pi*f")
                .dynamic("r", "mode_displacement", &at.position_unit())
                .dynamic("r_dot", "mode_velocity", &at.velocity_unit())
                .define("P", "mode_pull", "w^2*r + 2*z*w*r_dot")
                .moves("r", "r_dot")
                .moves("r_dot", "-a - (1 + m)*P")
                .force("mode_force", "m*P/C");
            vec![mode.starts(starts.clone())]
        })
    }
}
