//! Laws of logs as people have them: parameters that walk, and signals inside the model.

use super::{
    input::Lag,
    law::{History, Law, Mechanism, Needs, Place, Setting},
    origin::Origin,
};

/// Points of the path of a parameter.
const POINTS: usize = 400;

const fn inside(
    label: &'static str,
    family: &'static str,
    range: [f64; 2],
    build: fn(&Setting<'_>) -> Mechanism,
) -> Law {
    let (place, needs) = (Place::Inside, Needs::Nothing);
    Law { label, name: "inside", family, place, origin: Origin::Inside, needs, range, build }
}

fn signal(law: impl FnMut(f64, f64) -> f64 + Send + 'static) -> Mechanism {
    Mechanism::Inside(Box::new(law))
}

pub(super) fn laws() -> Vec<Law> {
    let mut all = vec![Law {
        label: "wandering-parameter",
        name: "random-walk",
        family: "parameter",
        place: Place::Parameter,
        origin: Origin::Wander,
        needs: Needs::Nothing,
        range: [0.02, 0.6],
        build: |s| {
            // After a whole log it is about so far away; it begins where it should be.
            let (mut random, step) = (s.random(), s.strength / (POINTS as f64).sqrt());
            let mut path = vec![0.0];
            for k in 0..2 * POINTS {
                path.push(path[k] + step * random.normal());
            }
            let pace = POINTS as f64 / s.scales.duration;
            Mechanism::Factor(Box::new(move |t| {
                let (whole, part) = ((t * pace).floor(), (t * pace).fract());
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a time"
                )]
                let k = (whole as usize).min(path.len() - 2);
                (path[k] + part * (path[k + 1] - path[k])).clamp(-1.5, 1.5).exp()
            }))
        },
    }];
    all.extend(signals());
    all
}

/// What can happen to a signal inside.
fn signals() -> Vec<Law> {
    vec![
        inside("inner-gain", "inner-gain", [5e-3, 0.6], |s| {
            let e = s.sign() * s.strength;
            signal(move |w, _| w * (1.0 + e))
        }),
        inside("inner-offset", "inner-offset", [5e-3, 1.0], |s| {
            let o = s.sign() * s.strength * s.inner().std;
            signal(move |w, _| w + o)
        }),
        inside("inner-saturation", "inner-nonlinearity", [0.02, 0.7], |s| {
            let (mean, peak) = (s.inner().mean, s.inner().high - s.inner().mean);
            let limit = mean + (1.0 - s.strength) * peak;
            signal(move |w, _| w.min(limit))
        }),
        inside("inner-dead-zone", "inner-nonlinearity", [5e-3, 0.6], |s| {
            let w = s.strength * s.inner().peak;
            signal(move |value, _| value - value.clamp(-w, w))
        }),
        inside("inner-curve", "inner-nonlinearity", [0.02, 1.0], |s| {
            let (mean, std, e) = (s.inner().mean, s.inner().std, s.sign() * s.strength);
            signal(move |w, _| {
                let d = (w - mean) / std;
                w + 0.3 * e * std * d * d.abs() / (1.0 + 0.2 * d.abs())
            })
        }),
        inside("inner-delay", "inner-dynamics", [0.1, 15.0], |s| {
            let (late, mut past) = (s.strength * s.scales.ts, History::default());
            signal(move |w, h| past.after(w, late / h))
        }),
        inside("inner-lag", "inner-dynamics", [0.1, 15.0], |s| {
            let (time, mut lag) = (s.strength * s.scales.ts, Lag::new());
            signal(move |w, h| lag.step(w, time, h))
        }),
    ]
}
