//! What sensors do.

use super::{
    input::{Lag, Play},
    law::{History, Law, Measured, Mechanism, Needs, Place, Setting},
    origin::Origin,
};

pub(super) fn sensor(law: impl FnMut(&Measured<'_>) -> f64 + Send + 'static) -> Mechanism {
    Mechanism::Sensor(Box::new(law))
}

const fn law(
    label: &'static str,
    name: &'static str,
    family: &'static str,
    origin: Origin,
    range: [f64; 2],
    build: fn(&Setting<'_>) -> Mechanism,
) -> Law {
    Law { label, name, family, place: Place::Output, origin, needs: Needs::Nothing, range, build }
}

const fn measurement(
    label: &'static str,
    name: &'static str,
    origin: Origin,
    range: [f64; 2],
    build: fn(&Setting<'_>) -> Mechanism,
) -> Law {
    let law = law(label, name, "sensor-noise", origin, range, build);
    Law { needs: Needs::Measurement, ..law }
}

#[allow(clippy::too_many_lines, reason = "a table of laws")]
pub(super) fn laws() -> Vec<Law> {
    use Origin::{Matched, Mismatch};
    let (offset, curve, dynamic) = ("sensor-offset", "sensor-nonlinearity", "sensor-dynamics");
    vec![
        law("sensor-bias", "constant", offset, Matched, [1e-3, 1.0], |s| {
            let b = s.sign() * s.strength * s.output().std;
            sensor(move |m| m.y + b)
        }),
        law("sensor-drift", "linear", offset, Matched, [2e-3, 2.0], |s| {
            let r = s.sign() * s.strength * s.output().std / s.scales.duration;
            sensor(move |m| m.y + r * m.t)
        }),
        law("sensor-drift", "settling", offset, Matched, [2e-3, 2.0], |s| {
            let b = s.sign() * s.strength * s.output().std;
            let time = s.scales.duration * s.shape(1, 0.1, 0.5);
            sensor(move |m| m.y + b * (1.0 - (-m.t / time).exp()))
        }),
        law("sensor-drift", "up-and-down", offset, Mismatch, [2e-3, 1.0], |s| {
            let b = s.sign() * s.strength * s.output().std;
            let (turns, length) = (s.shape(1, 2.5, 6.0), s.scales.duration);
            sensor(move |m| m.y + b * ((turns * m.t / length).cos() - 1.0))
        }),
        law("sensor-scale", "linear", "sensor-gain", Matched, [1e-3, 0.5], |s| {
            let e = s.sign() * s.strength;
            sensor(move |m| m.y * (1.0 + e))
        }),
        law("sensor-scale", "bent", "sensor-gain", Mismatch, [1e-3, 0.5], |s| {
            let (e, size) = (s.sign() * s.strength, s.output().peak);
            sensor(move |m| m.y * (1.0 + e * m.y.abs() / size))
        }),
        law("sensor-lag", "order-1", dynamic, Matched, [0.02, 10.0], |s| {
            let (time, mut lag) = (s.strength * s.scales.ts, Ramp(None));
            sensor(move |m| lag.step(m.y, time, m.h))
        }),
        law("sensor-lag", "order-2", dynamic, Matched, [0.02, 6.0], |s| {
            let time = s.strength * s.scales.ts;
            let (second, mut lags) = (time * s.shape(1, 0.2, 0.9), [Ramp(None), Ramp(None)]);
            sensor(move |m| {
                let first = lags[0].step(m.y, time, m.h);
                lags[1].step(first, second, m.h)
            })
        }),
        law("sensor-lag", "two-speeds", dynamic, Mismatch, [0.05, 8.0], |s| {
            let (up, down) =
                (s.strength * s.scales.ts, s.strength * s.scales.ts * s.shape(1, 0.2, 0.5));
            let mut lag = Lag::new();
            sensor(move |m| {
                let rises = lag.0.is_some_and(|b| b < m.y);
                lag.step(m.y, if rises { up } else { down }, m.h)
            })
        }),
        law("sensor-delay", "pure", dynamic, Matched, [0.02, 10.0], |s| {
            let (late, mut past) = (s.strength * s.scales.ts, History::default());
            sensor(move |m| past.after(m.y, late / m.h))
        }),
        law("sensor-delay", "growing", dynamic, Mismatch, [0.02, 10.0], |s| {
            let (late, mut past) = (s.strength * s.scales.ts, History::default());
            let length = s.scales.duration;
            sensor(move |m| past.after(m.y, late * (0.5 + m.t / length) / m.h))
        }),
        law("sensor-saturation", "both", curve, Matched, [3e-3, 0.6], |s| {
            let (low, high) = range(s);
            sensor(move |m| m.y.clamp(low, high))
        }),
        law("sensor-saturation", "one", curve, Matched, [3e-3, 0.6], |s| {
            let ((low, high), sign) = (range(s), s.sign());
            sensor(move |m| if sign < 0.0 { m.y.max(low) } else { m.y.min(high) })
        }),
        law("sensor-saturation", "rounded", curve, Mismatch, [0.05, 1.5], |s| {
            let out = s.output();
            let (middle, half) = (0.5 * (out.low + out.high), 0.5 * (out.high - out.low));
            let limit = half / s.strength;
            sensor(move |m| middle + limit * ((m.y - middle) / limit).tanh())
        }),
        law("sensor-backlash", "play", curve, Matched, [5e-3, 1.0], |s| {
            let (w, mut play) = (s.strength * s.output().std, Play::new());
            sensor(move |m| play.step(m.y, w))
        }),
        law("sensor-backlash", "with-slip", curve, Mismatch, [5e-3, 1.0], |s| {
            // What hangs in the play creeps back to the middle.
            let (w, mut shown) = (s.strength * s.output().std, None);
            let time = s.scales.duration * s.shape(1, 0.02, 0.2);
            sensor(move |m| {
                let b: &mut f64 = shown.get_or_insert(m.y);
                *b = (*b + (m.y - *b) * m.h / time).clamp(m.y - w, m.y + w);
                *b
            })
        }),
        Law {
            needs: Needs::Partner,
            ..law("sensor-cross-talk", "linear", "coupling", Matched, [1e-3, 0.6], |s| {
                let (c, other, mean) = talk(s);
                sensor(move |m| m.y + c * (m.all[other] - mean))
            })
        },
        Law {
            needs: Needs::Partner,
            ..law("sensor-cross-talk", "late", "coupling", Mismatch, [1e-3, 0.6], |s| {
                let ((c, other, mean), time) = (talk(s), 5.0 * s.scales.ts);
                let mut lag = Lag::new();
                sensor(move |m| m.y + c * (lag.step(m.all[other], time, m.h) - mean))
            })
        },
        measurement("sensor-quantisation", "round", Matched, [1.5, 30.0], |s| {
            let q = s.strength;
            Mechanism::Corrupt(Box::new(move |y, noise, sigma| {
                q * sigma * ((y + noise) / (q * sigma)).round()
            }))
        }),
        measurement("sensor-outliers", "share", Matched, [4e-3, 0.05], |s| {
            let (share, mut random) = (s.strength, s.random());
            let size = s.shape(1, 8.0, 40.0);
            Mechanism::Corrupt(Box::new(move |y, noise, sigma| {
                let is_hit = random.unit() < share;
                let far = random.sign() * size * random.uniform(0.5, 1.0) * sigma;
                y + noise + if is_hit { far } else { 0.0 }
            }))
        }),
        measurement("sensor-noise", "white", Matched, [1.3, 4.0], |s| {
            // White where the stated noise is not.
            let (extra, mut random) = ((s.strength.powi(2) - 1.0).sqrt(), s.random());
            Mechanism::Corrupt(Box::new(move |y, noise, sigma| {
                y + noise + extra * sigma * random.normal()
            }))
        }),
        measurement("sensor-noise", "heavy-tailed", Mismatch, [1.3, 3.0], |s| {
            let factor = s.strength / std::f64::consts::SQRT_2;
            let mut random = s.random();
            Mechanism::Corrupt(Box::new(move |y, _, sigma| {
                let size = -(1.0 - random.unit()).ln();
                y + factor * sigma * random.sign() * size
            }))
        }),
    ]
}

/// A lag of a quantity that goes in straight lines from step to step; its value at the end.
struct Ramp(Option<(f64, f64)>);

impl Ramp {
    fn step(&mut self, y: f64, time: f64, h: f64) -> f64 {
        let (before, lagged) = *self.0.get_or_insert((y, y));
        let (k, slope) = ((-h / time).exp(), (y - before) / h);
        let now = y - slope * time + (lagged - before + slope * time) * k;
        self.0 = Some((y, now));
        now
    }
}

/// Limits of a sensor whose range is too short by the strength, at both ends.
fn range(s: &Setting<'_>) -> (f64, f64) {
    let out = s.output();
    let cut = 0.5 * s.strength * (out.high - out.low);
    (out.low + cut, out.high - cut)
}

fn talk(s: &Setting<'_>) -> (f64, usize, f64) {
    let other = &s.scales.outputs[s.partner];
    (s.sign() * s.strength * s.output().std / other.std, s.partner, other.mean)
}
