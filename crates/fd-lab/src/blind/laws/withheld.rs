//! Causes that no label of the library stands for.

use super::{
    force::{force, memory},
    input::{Lag, input},
    law::{History, Law, Mechanism, Needs, Place, Setting},
    origin::Origin,
    sensor::sensor,
};

const fn law(
    label: &'static str,
    (place, needs): (Place, Needs),
    range: [f64; 2],
    build: fn(&Setting<'_>) -> Mechanism,
) -> Law {
    let family = match place {
        Place::Input => "withheld-input",
        Place::Force | Place::Parameter | Place::Inside => "withheld-dynamics",
        Place::Output => "withheld-sensor",
    };
    Law { label, name: "withheld", family, place, origin: Origin::Withheld, needs, range, build }
}

pub(super) fn laws() -> Vec<Law> {
    let mut all = of_actuators();
    all.extend(of_plants());
    all.extend(of_sensors());
    all
}

fn of_actuators() -> Vec<Law> {
    let input_law = (Place::Input, Needs::Nothing);
    vec![
        // Gain that falls while the actuator is hot; heat comes from its load.
        law("heating-actuator", input_law, [5e-3, 0.8], |s| {
            let (loss, usual) = (s.strength, s.input().peak);
            let (time, mut heat) = (s.scales.duration * s.shape(1, 0.05, 0.2), Lag::new());
            input(move |a| {
                let load = (a.u / usual).powi(2);
                let first = a.t <= 0.0;
                let hot = heat.step(if first { 0.0 } else { load }, time, a.h);
                a.u * (1.0 - loss * hot)
            })
        }),
        // Bursts without any power.
        law("intermittent-actuator", input_law, [2e-3, 0.3], |s| {
            let (share, mut random, length) = (s.strength, s.random(), 12.0 * s.scales.ts);
            let (mut until, mut is_out) = (0.0, false);
            input(move |a| {
                if until <= a.t {
                    is_out = random.unit() < share;
                    until = a.t + random.uniform(0.5, 1.5) * length;
                }
                if is_out { 0.0 } else { a.u }
            })
        }),
        // The larger the flow the shorter the pipe.
        law("flow-dependent-delay", input_law, [0.2, 25.0], |s| {
            let (late, usual) = (s.strength * s.scales.ts, s.input().std);
            let mut past = History::default();
            input(move |a| {
                let now = late / (1.0 + (a.u / usual).powi(2));
                past.after(a.u, now / a.h)
            })
        }),
        // First the wrong way: (1 - s T)/(1 + s T).
        law("inverse-response", input_law, [0.05, 8.0], |s| {
            let (time, mut lag) = (s.strength * s.scales.ts, Lag::new());
            input(move |a| 2.0 * lag.step(a.u, time, a.h) - a.u)
        }),
        // A gain that swings slowly.
        law("swinging-gain", input_law, [5e-3, 0.6], |s| {
            let (e, w) = (s.strength, s.shape(1, 8.0, 25.0) / s.scales.duration);
            input(move |a| a.u * (1.0 + e * (w * a.t).sin()))
        }),
    ]
}

fn of_plants() -> Vec<Law> {
    vec![
        // A stiffness (or damping) that is pumped.
        law("parametric-excitation", (Place::Force, Needs::Velocity), [5e-3, 0.8], |s| {
            let size = s.strength * s.site().force;
            let (length, usual) = (s.position(), s.velocity());
            let w = s.shape(1, 15.0, 80.0) / s.scales.duration;
            force(move |at| {
                let of = if at.x.is_finite() { at.x / length } else { at.v / usual };
                at.against(size * of * (w * at.t).sin())
            })
        }),
        // Friction that grows at rest and falls with every slip (rate and state), with creep.
        law("ageing-friction", (Place::Force, Needs::Reversal), [5e-3, 0.6], |s| {
            let (f, usual) = (s.strength * s.site().force, s.velocity());
            let length = s.position() * s.shape(1, 0.2, 0.8);
            memory(
                1,
                move |at, z| {
                    let age = (1.0 + z[0] * usual / length).ln();
                    at.against(f * (0.2 + age) * (at.v / (0.05 * usual)).asinh() / 3.0)
                },
                move |at, z, dz| dz[0] = 1.0 - at.v.abs() * z[0] / length,
            )
        }),
        // Gusts: low-pass filtered noise.
        law("random-force", (Place::Force, Needs::Nothing), [5e-3, 0.6], |s| {
            let (size, time) = (s.strength * s.site().force, 15.0 * s.scales.ts);
            let (mut random, mut now) = (s.random(), 0.0);
            Mechanism::HeldForce(Box::new(move |_, h| {
                let k = (-h / time).exp();
                now = k * now + (1.0 - k * k).sqrt() * random.normal();
                size * now
            }))
        }),
        // Knocks.
        law("impacts", (Place::Force, Needs::Nothing), [0.02, 8.0], |s| {
            let (size, ts) = (s.strength * s.site().force, s.scales.ts);
            let mut random = s.random();
            let (mut next, mut now) = (s.scales.duration * 0.05, 0.0);
            let gap = s.scales.duration / 12.0;
            let mut t = 0.0;
            Mechanism::HeldForce(Box::new(move |_, h| {
                t += h;
                if next + 2.0 * ts <= t {
                    (next, now) = (t + gap * random.uniform(0.4, 1.6), 0.0);
                } else if next <= t && now == 0.0 {
                    now = size * random.sign();
                }
                now
            }))
        }),
        // A parameter that is not constant.
        law("varying-parameter", (Place::Parameter, Needs::Nothing), [0.02, 0.7], |s| {
            let (e, w) = (s.strength, s.shape(1, 6.0, 25.0) / s.scales.duration);
            Mechanism::Factor(Box::new(move |t| 1.0 + e * (w * t).sin()))
        }),
    ]
}

fn of_sensors() -> Vec<Law> {
    let output_law = (Place::Output, Needs::Nothing);
    vec![
        // It answers less the more it had to measure before.
        law("tiring-sensor", output_law, [5e-3, 1.5], |s| {
            let (e, out) = (s.strength, s.output());
            let (mean, std, mut lag) = (out.mean, out.std, Lag::new());
            let time = s.scales.duration * s.shape(1, 0.01, 0.05);
            sensor(move |m| {
                let d = (m.y - mean) / std;
                let tired = lag.step(d.abs(), time, m.h);
                mean + std * d / (1.0 + e * tired)
            })
        }),
        // Bursts in which it shows an old value.
        law("freezing-sensor", output_law, [2e-3, 0.4], |s| {
            let (share, mut random, length) = (s.strength, s.random(), 10.0 * s.scales.ts);
            let (mut until, mut held) = (0.0, None);
            sensor(move |m| {
                if until <= m.t {
                    held = (random.unit() < share).then_some(m.y);
                    until = m.t + random.uniform(0.5, 1.5) * length;
                }
                held.unwrap_or(m.y)
            })
        }),
        // Its clock is wrong by a part of the log.
        law("clock-error", output_law, [2e-5, 0.02], |s| {
            let (rate, mut past) = (s.strength, History::default());
            sensor(move |m| past.after(m.y, rate * m.t / m.h))
        }),
        // It overshoots: a lightly damped sensor.
        law("ringing-sensor", output_law, [0.02, 5.0], |s| {
            let w = 1.0 / (s.strength * s.scales.ts);
            let (damping, mut state) = (s.shape(1, 0.1, 0.3), None);
            sensor(move |m| {
                let (y, v) = state.get_or_insert((m.y, 0.0));
                if 20.0 < w * m.h {
                    // Over before the step is.
                    return m.y;
                }
                // Small steps for a fast one: h w below a tenth.
                let steps = (10.0 * w * m.h).ceil().clamp(1.0, 200.0);
                let h = m.h / steps;
                let mut left = steps;
                while 0.5 < left {
                    *v += h * (w * w * (m.y - *y) - 2.0 * damping * w * *v);
                    *y += h * *v;
                    left -= 1.0;
                }
                *y
            })
        }),
    ]
}
