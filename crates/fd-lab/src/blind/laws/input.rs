//! What actuators do.

use super::{
    law::{Arriving, History, Law, Mechanism, Needs, Place, Setting},
    origin::Origin,
};

pub(super) fn input(law: impl FnMut(&Arriving<'_>) -> f64 + Send + 'static) -> Mechanism {
    Mechanism::Input(Box::new(law))
}

const fn law(
    label: &'static str,
    name: &'static str,
    family: &'static str,
    origin: Origin,
    range: [f64; 2],
    build: fn(&Setting<'_>) -> Mechanism,
) -> Law {
    Law { label, name, family, place: Place::Input, origin, needs: Needs::Nothing, range, build }
}

/// A first-order lag: its value, and the mean over a step of which the input is held.
pub(super) struct Lag(pub(super) Option<f64>);

impl Lag {
    pub(super) fn new() -> Self {
        Self(None)
    }

    pub(super) fn step(&mut self, u: f64, time: f64, h: f64) -> f64 {
        let before = *self.0.get_or_insert(u);
        let k = (-h / time).exp();
        self.0 = Some(u + (before - u) * k);
        u + (before - u) * (1.0 - k) * time / h
    }
}

/// Play between `b - w` and `b + w`.
pub(super) struct Play(Option<f64>);

impl Play {
    pub(super) const fn new() -> Self {
        Self(None)
    }

    pub(super) fn step(&mut self, u: f64, w: f64) -> f64 {
        let b = self.0.get_or_insert(u);
        *b = b.clamp(u - w, u + w);
        *b
    }
}

pub(super) fn laws() -> Vec<Law> {
    let mut all = statics();
    all.extend(dynamics());
    all
}

#[allow(clippy::too_many_lines, reason = "a table of laws")]
fn statics() -> Vec<Law> {
    use Origin::{Matched, Mismatch};
    let (gain, offset) = ("actuator-gain", "actuator-offset");
    let curve = "actuator-nonlinearity";
    vec![
        law("input-gain", "symmetric", gain, Matched, [3e-3, 0.6], |s| {
            let e = s.sign() * s.strength;
            input(move |a| a.u * (1.0 + e))
        }),
        law("input-gain", "asymmetric", gain, Matched, [3e-3, 0.6], |s| {
            let (up, down) = (s.sign() * s.strength, s.shape(1, -0.8, 0.4) * s.strength);
            input(move |a| a.u * (1.0 + if a.u > 0.0 { up } else { down }))
        }),
        law("input-gain", "small-signal", gain, Mismatch, [3e-3, 0.9], |s| {
            let (e, size) = (s.sign() * s.strength, s.input().std * s.shape(1, 0.3, 0.8));
            input(move |a| a.u * (1.0 + e / (1.0 + (a.u / size).powi(2))))
        }),
        law("input-offset", "constant", offset, Matched, [2e-3, 2.0], |s| {
            let o = s.sign() * s.strength * s.input().std;
            input(move |a| a.u + o)
        }),
        law("input-offset", "settling", offset, Mismatch, [2e-3, 2.0], |s| {
            let o = s.sign() * s.strength * s.input().std;
            let time = s.scales.duration * s.shape(1, 0.1, 0.4);
            input(move |a| a.u + o * (0.5 + (-a.t / time).exp()))
        }),
        law("input-dead-zone", "symmetric", curve, Matched, [2e-3, 0.6], |s| {
            let w = s.strength * s.input().peak;
            input(move |a| a.u - a.u.clamp(-w, w))
        }),
        law("input-dead-zone", "asymmetric", curve, Matched, [2e-3, 0.6], |s| {
            let w = s.strength * s.input().peak;
            let share = s.sign() * s.shape(1, 0.2, 0.7);
            input(move |a| a.u - a.u.clamp(-w * (1.0 - share), w * (1.0 + share)))
        }),
        law("input-dead-zone", "rounded", curve, Mismatch, [2e-3, 0.6], |s| {
            let w = s.strength * s.input().peak;
            input(move |a| a.u - w * (a.u / w).tanh())
        }),
        law("input-dead-zone", "jumping", curve, Mismatch, [2e-3, 0.6], |s| {
            let w = s.strength * s.input().peak;
            input(move |a| if a.u.abs() < w { 0.0 } else { a.u })
        }),
        law("input-saturation", "hard", curve, Matched, [5e-3, 0.7], |s| {
            let limit = (1.0 - s.strength) * s.input().peak;
            input(move |a| a.u.clamp(-limit, limit))
        }),
        law("input-saturation", "soft", curve, Matched, [0.2, 1.6], |s| {
            let (limit, n) = (s.input().peak / s.strength, s.shape(1, 3.0, 10.0));
            input(move |a| a.u / (1.0 + (a.u / limit).abs().powf(n)).powf(1.0 / n))
        }),
        law("input-saturation", "tanh", curve, Matched, [0.05, 1.6], |s| {
            let limit = s.input().peak / s.strength;
            input(move |a| limit * (a.u / limit).tanh())
        }),
        law("input-saturation", "asymmetric", curve, Matched, [5e-3, 0.7], |s| {
            let (limit, other) = ((1.0 - s.strength) * s.input().peak, s.shape(1, 1.1, 1.6));
            let (low, high) = if s.sign() < 0.0 { (1.0, other) } else { (other, 1.0) };
            input(move |a| a.u.clamp(-limit * low, limit * high))
        }),
        law("input-saturation", "rational", curve, Mismatch, [0.02, 1.6], |s| {
            let limit = s.input().peak / s.strength;
            input(move |a| a.u / (1.0 + (a.u / limit).abs()))
        }),
        law("input-saturation", "arctangent", curve, Mismatch, [0.05, 1.6], |s| {
            let limit = s.input().peak / s.strength;
            input(move |a| limit * (a.u / limit).atan())
        }),
        law("input-quantisation", "round", curve, Matched, [5e-3, 0.6], |s| {
            let q = s.strength * s.input().peak;
            input(move |a| q * (a.u / q).round())
        }),
        law("input-quantisation", "towards-zero", curve, Matched, [5e-3, 0.6], |s| {
            let q = s.strength * s.input().peak;
            input(move |a| q * (a.u / q).trunc())
        }),
        law("input-quantisation", "downwards", curve, Matched, [5e-3, 0.6], |s| {
            let q = s.strength * s.input().peak;
            input(move |a| q * (a.u / q).floor())
        }),
        law("input-quantisation", "few-digits", curve, Mismatch, [0.02, 1.0], |s| {
            // As many digits for small commands as for large ones.
            let (digit, least) = (s.strength, 1e-3 * s.input().peak);
            input(move |a| {
                let q = digit * a.u.abs().max(least).log2().floor().exp2();
                q * (a.u / q).round()
            })
        }),
        Law {
            needs: Needs::Partner,
            ..law("input-cross-coupling", "linear", "coupling", Matched, [3e-3, 0.6], |s| {
                let c = s.sign() * s.strength * s.input().std / s.scales.inputs[s.partner].std;
                let other = s.partner;
                input(move |a| a.u + c * a.all[other])
            })
        },
        Law {
            needs: Needs::Partner,
            ..law("input-cross-coupling", "threshold", "coupling", Mismatch, [3e-3, 0.8], |s| {
                let from = &s.scales.inputs[s.partner];
                let c = s.sign() * s.strength * s.input().std / from.std;
                let (other, mean) = (s.partner, from.mean);
                input(move |a| a.u + c * (a.all[other] - mean).max(0.0))
            })
        },
    ]
}

#[allow(clippy::too_many_lines, reason = "a table of laws")]
fn dynamics() -> Vec<Law> {
    use Origin::{Matched, Mismatch};
    let (dynamic, curve) = ("actuator-dynamics", "actuator-nonlinearity");
    vec![
        law("input-backlash", "play", curve, Matched, [2e-3, 0.5], |s| {
            let (w, mut play) = (s.strength * s.input().peak, Play::new());
            input(move |a| play.step(a.u, w))
        }),
        law("input-backlash", "many-plays", curve, Mismatch, [2e-3, 0.6], |s| {
            let w = s.strength * s.input().peak;
            let mut plays = [0.3, 0.7, 1.2, 1.8].map(|share| (share, Play::new()));
            input(move |a| {
                plays.iter_mut().map(|(k, play)| play.step(a.u, *k * w)).sum::<f64>() / 4.0
            })
        }),
        law("input-delay", "pure", dynamic, Matched, [0.03, 12.0], |s| {
            let (late, mut past) = (s.strength * s.scales.ts, History::default());
            input(move |a| past.after(a.u, late / a.h))
        }),
        law("input-delay", "jittering", dynamic, Mismatch, [0.1, 12.0], |s| {
            let (late, mut past) = (s.strength * s.scales.ts, History::default());
            let (mut random, ts) = (s.random(), s.scales.ts);
            let (mut until, mut now) = (0.0, 1.0);
            input(move |a| {
                if until <= a.t {
                    (until, now) = (a.t + 3.0 * ts, random.uniform(0.5, 1.5));
                }
                past.after(a.u, now * late / a.h)
            })
        }),
        law("input-lag", "order-1", dynamic, Matched, [0.03, 12.0], |s| {
            let (time, mut lag) = (s.strength * s.scales.ts, Lag::new());
            input(move |a| lag.step(a.u, time, a.h))
        }),
        law("input-lag", "order-2", dynamic, Matched, [0.03, 8.0], |s| {
            let time = s.strength * s.scales.ts;
            let (second, mut lags) = (time * s.shape(1, 0.2, 0.9), [Lag::new(), Lag::new()]);
            input(move |a| {
                let first = lags[0].step(a.u, time, a.h);
                lags[1].step(first, second, a.h)
            })
        }),
        law("input-lag", "two-speeds", dynamic, Mismatch, [0.05, 10.0], |s| {
            let (up, down) =
                (s.strength * s.scales.ts, s.strength * s.scales.ts * s.shape(1, 0.2, 0.5));
            let mut lag = Lag::new();
            input(move |a| {
                let rises = lag.0.is_some_and(|b| b < a.u);
                lag.step(a.u, if rises { up } else { down }, a.h)
            })
        }),
        law("input-lag", "order-3", dynamic, Mismatch, [0.03, 5.0], |s| {
            let (time, mut lags) = (s.strength * s.scales.ts, [Lag::new(), Lag::new(), Lag::new()]);
            input(move |a| lags.iter_mut().fold(a.u, |u, lag| lag.step(u, time, a.h)))
        }),
        law("input-rate-limit", "symmetric", dynamic, Matched, [0.05, 40.0], |s| {
            let (rate, mut b) = (s.input().std / (s.strength * s.scales.ts), None);
            input(move |a| follow(&mut b, a, rate, rate))
        }),
        law("input-rate-limit", "asymmetric", dynamic, Matched, [0.05, 40.0], |s| {
            let rate = s.input().std / (s.strength * s.scales.ts);
            let other = rate * s.shape(1, 1.5, 4.0);
            let (up, down) = if s.sign() < 0.0 { (rate, other) } else { (other, rate) };
            let mut b = None;
            input(move |a| follow(&mut b, a, up, down))
        }),
        law("input-rate-limit", "soft", dynamic, Mismatch, [0.05, 40.0], |s| {
            let rate = s.input().std / (s.strength * s.scales.ts);
            let (knee, mut b) = (s.input().std * s.shape(1, 0.5, 2.0), None);
            input(move |a| {
                // Slower near the end of the way.
                let away = (a.u - *b.get_or_insert(a.u)).abs();
                reach(&mut b, a, rate * (0.2 + (away / knee).tanh()))
            })
        }),
    ]
}

/// Moves towards what arrives, at no more than these rates; the mean over the step.
fn follow(b: &mut Option<f64>, a: &Arriving<'_>, up: f64, down: f64) -> f64 {
    let before = *b.get_or_insert(a.u);
    let away = a.u - before;
    reach(b, a, if 0.0 < away { up } else { down })
}

/// The same at one rate. What arrives within the step stays there for the rest of it.
fn reach(b: &mut Option<f64>, a: &Arriving<'_>, rate: f64) -> f64 {
    let before = *b.get_or_insert(a.u);
    let away = a.u - before;
    let steps = away.abs() / (rate * a.h);
    if steps <= 1.0 {
        *b = Some(a.u);
        a.u - 0.5 * steps * away
    } else {
        *b = Some(before + away / steps);
        before + 0.5 * away / steps
    }
}
