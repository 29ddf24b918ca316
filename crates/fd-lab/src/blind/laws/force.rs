//! Forces inside the plant, and errors of its parameters.

use super::{
    law::{Law, Mechanism, Needs, Place, Setting, Site},
    origin::Origin,
};

pub(super) fn force(law: impl Fn(&Site<'_>) -> f64 + Send + 'static) -> Mechanism {
    Mechanism::Force {
        states: 0,
        accelerated: false,
        force: Box::new(move |site, _| law(site)),
        rates: Box::new(|_, _, _| ()),
    }
}

pub(super) fn memory(
    states: usize,
    force: impl Fn(&Site<'_>, &[f64]) -> f64 + Send + 'static,
    rates: impl Fn(&Site<'_>, &[f64], &mut [f64]) + Send + 'static,
) -> Mechanism {
    let (force, rates) = (Box::new(force), Box::new(rates));
    Mechanism::Force { states, accelerated: false, force, rates }
}

/// Friction of the same level for both directions.
fn stick(level: impl Fn(&Site<'_>) -> f64 + Send + 'static) -> Mechanism {
    Mechanism::Stick(Box::new(move |site, _| [level(site); 2]))
}

const fn law(
    label: &'static str,
    name: &'static str,
    family: &'static str,
    (origin, needs): (Origin, Needs),
    range: [f64; 2],
    build: fn(&Setting<'_>) -> Mechanism,
) -> Law {
    Law { label, name, family, place: Place::Force, origin, needs, range, build }
}

pub(super) fn laws() -> Vec<Law> {
    let mut all = friction();
    all.extend(springs_and_loads());
    all.extend(memories_and_limits());
    all
}

/// Amount of force, velocity and position in the scales of the site.
fn unit_force(s: &Setting<'_>) -> f64 {
    s.strength * s.site().force
}

#[allow(clippy::too_many_lines, reason = "a table of laws")]
fn friction() -> Vec<Law> {
    use Needs::{Reversal, Velocity};
    use Origin::{Matched, Mismatch};
    let rubs = "friction";
    let dry = "coulomb-friction";
    vec![
        law("viscous-friction", "linear", rubs, (Matched, Velocity), [2e-3, 1.5], |s| {
            let c = unit_force(s) / s.velocity();
            force(move |at| at.against(c * at.v))
        }),
        law(dry, "symmetric", rubs, (Matched, Reversal), [2e-3, 0.6], |s| {
            let level = unit_force(s);
            stick(move |_| level)
        }),
        law(dry, "direction-dependent", rubs, (Matched, Reversal), [2e-3, 0.6], |s| {
            let (level, share) = (unit_force(s), s.sign() * s.shape(1, 0.2, 0.7));
            let levels = [level * (1.0 + share), level * (1.0 - share)];
            Mechanism::Stick(Box::new(move |_, _| levels))
        }),
        law(dry, "stribeck", rubs, (Matched, Reversal), [2e-3, 0.5], |s| {
            let (level, more) = (unit_force(s), s.shape(1, 0.4, 1.5));
            let slow = s.velocity() * s.shape(2, 0.1, 0.5);
            stick(move |at| level * (1.0 + more * (-(at.v / slow).powi(2)).exp()))
        }),
        law(dry, "load-dependent", rubs, (Matched, Reversal), [2e-3, 0.4], |s| {
            let (level, per_load) = (0.3 * unit_force(s), 0.7 * s.strength);
            stick(move |at| level + per_load * (at.a / at.c).abs())
        }),
        law(dry, "place-dependent", rubs, (Mismatch, Needs::Reversal), [2e-3, 0.6], |s| {
            let (level, length) = (unit_force(s), s.position() * s.shape(1, 0.5, 1.5));
            stick(move |at| {
                let place = if at.x.is_finite() { at.x / length } else { at.t };
                level * (1.0 + 0.6 * place.sin())
            })
        }),
        law(dry, "wearing-in", rubs, (Mismatch, Reversal), [2e-3, 0.6], |s| {
            let (level, time) = (unit_force(s), s.scales.duration * s.shape(1, 0.2, 0.6));
            stick(move |at| level * (0.6 + 0.8 * (-at.t / time).exp()))
        }),
        law(dry, "shallow", rubs, (Mismatch, Reversal), [2e-3, 0.6], |s| {
            let (level, creep) = (unit_force(s), s.velocity() * s.shape(1, 0.15, 0.4));
            force(move |at| at.against(level * at.v / (at.v.abs() + creep)))
        }),
        law("drag", "quadratic", rubs, (Matched, Velocity), [2e-3, 1.0], |s| {
            let c = unit_force(s) / s.velocity().powi(2);
            force(move |at| at.against(c * at.v * at.v.abs()))
        }),
        law("drag", "power", rubs, (Matched, Velocity), [2e-3, 1.0], |s| {
            let (c, usual) = (unit_force(s), s.velocity());
            let power = if s.sign() < 0.0 { 1.5 } else { 3.0 };
            force(move |at| at.against(c * (at.v / usual).abs().powf(power).copysign(at.v)))
        }),
        law("drag", "one-way", rubs, (Mismatch, Reversal), [2e-3, 1.0], |s| {
            let (c, sign) = (unit_force(s) / s.velocity().powi(2), s.sign());
            force(move |at| {
                at.against(c * at.v * at.v.abs() * if sign * at.v > 0.0 { 1.6 } else { 0.4 })
            })
        }),
    ]
}

#[allow(clippy::too_many_lines, reason = "a table of laws")]
fn springs_and_loads() -> Vec<Law> {
    use Needs::{Angle, Nothing, Position};
    use Origin::{Matched, Mismatch};
    vec![
        law("linear-stiffness", "linear", "stiffness", (Matched, Position), [2e-3, 0.8], |s| {
            let k = unit_force(s) / s.position();
            force(move |at| at.against(k * at.x))
        }),
        law("stiffening", "cubic", "stiffness", (Matched, Position), [1e-3, 0.5], |s| {
            let k = unit_force(s) / s.position().powi(3);
            force(move |at| at.against(k * at.x.powi(3)))
        }),
        law("stiffening", "quintic", "stiffness", (Matched, Position), [3e-4, 0.2], |s| {
            let k = unit_force(s) / s.position().powi(5);
            force(move |at| at.against(k * at.x.powi(5)))
        }),
        law("stiffening", "asymmetric", "stiffness", (Matched, Position), [1e-3, 0.4], |s| {
            let (f, length, b) = (unit_force(s), s.position(), s.sign() * s.shape(1, 0.3, 1.0));
            force(move |at| {
                let x = at.x / length;
                at.against(f * (x.powi(3) + b * x * x))
            })
        }),
        law("stiffening", "hyperbolic", "stiffness", (Mismatch, Position), [2e-3, 0.5], |s| {
            let (f, length) = (unit_force(s), s.position() * s.shape(1, 0.6, 1.0));
            force(move |at| {
                let x = (at.x / length).clamp(-8.0, 8.0);
                at.against(f * (x.sinh() - x))
            })
        }),
        law("stiffening", "two-slopes", "stiffness", (Mismatch, Position), [2e-3, 1.0], |s| {
            let (k, free) = (unit_force(s) / s.position(), s.position() * s.shape(1, 0.5, 1.2));
            force(move |at| at.against(k * (at.x - at.x.clamp(-free, free))))
        }),
        law("constant-load", "constant", "load", (Matched, Nothing), [2e-3, 1.0], |s| {
            let f = s.sign() * unit_force(s);
            force(move |_| f)
        }),
        law("constant-load", "applied-late", "load", (Matched, Nothing), [2e-3, 1.0], |s| {
            let (f, since) = (s.sign() * unit_force(s), s.scales.duration * s.shape(1, 0.2, 0.6));
            force(move |at| if at.t < since { 0.0 } else { f })
        }),
        law("constant-load", "put-on-slowly", "load", (Matched, Nothing), [2e-3, 1.0], |s| {
            let (f, since) = (s.sign() * unit_force(s), s.scales.duration * s.shape(1, 0.2, 0.4));
            let lasts = s.scales.duration * s.shape(2, 0.1, 0.3);
            force(move |at| {
                let part = ((at.t - since) / lasts).clamp(0.0, 1.0);
                f * part * part * (3.0 - 2.0 * part)
            })
        }),
        law("constant-load", "comes-and-goes", "load", (Mismatch, Nothing), [2e-3, 1.0], |s| {
            let (f, since) = (s.sign() * unit_force(s), s.scales.duration * s.shape(1, 0.1, 0.4));
            let lasts = s.scales.duration * s.shape(2, 0.2, 0.5);
            force(move |at| if (since..since + lasts).contains(&at.t) { f } else { 0.0 })
        }),
        law("gravity-load", "sine", "load", (Matched, Angle), [2e-3, 1.0], |s| {
            let f = s.sign() * unit_force(s);
            force(move |at| f * at.x.sin())
        }),
        law("gravity-load", "sine-cosine", "load", (Matched, Angle), [2e-3, 1.0], |s| {
            let (f, b) = (s.sign() * unit_force(s), s.shape(1, -1.0, 1.0));
            force(move |at| f * (at.x.sin() + b * at.x.cos()))
        }),
        law("gravity-load", "two-lobes", "load", (Mismatch, Angle), [2e-3, 1.0], |s| {
            let f = s.sign() * unit_force(s);
            force(move |at| f * (at.x.sin() + 0.5 * (2.0 * at.x).sin()))
        }),
        law("periodic-force", "sinusoid", "load", (Matched, Nothing), [2e-3, 1.0], |s| {
            let (f, w, phase) = wave(s);
            force(move |at| f * (w * at.t + phase).sin())
        }),
        law("periodic-force", "square", "load", (Matched, Nothing), [2e-3, 1.0], |s| {
            let (f, w, phase) = wave(s);
            force(move |at| f.copysign((0.4 * w * at.t + phase).sin()))
        }),
        law("periodic-force", "sawtooth", "load", (Mismatch, Nothing), [2e-3, 1.0], |s| {
            let (f, w, phase) = wave(s);
            force(move |at| f * (2.0 * ((w * at.t + phase) / std::f64::consts::TAU).fract() - 1.0))
        }),
        law(
            "periodic-force",
            "swinging-frequency",
            "load",
            (Mismatch, Nothing),
            [2e-3, 1.0],
            |s| {
                let ((f, w, phase), duration) = (wave(s), s.scales.duration);
                force(move |at| f * (w * at.t * (1.0 + 0.1 * at.t / duration) + phase).sin())
            },
        ),
        Law {
            needs: Needs::Partner,
            ..law("state-coupling", "linear", "coupling", (Matched, Nothing), [3e-3, 0.8], |s| {
                let (other, state) = (s.partner, &s.scales.states[s.partner]);
                let (c, mean) = (s.sign() * unit_force(s) / state.std, state.mean);
                force(move |at| c * (at.states[other] - mean))
            })
        },
        Law {
            needs: Needs::Partner,
            ..law("state-coupling", "even", "coupling", (Mismatch, Nothing), [3e-3, 0.8], |s| {
                let (other, state) = (s.partner, &s.scales.states[s.partner]);
                let (c, mean, std) = (s.sign() * unit_force(s), state.mean, state.std);
                force(move |at| {
                    let b = (at.states[other] - mean) / std;
                    c * b * (1.0 + 0.7 * b)
                })
            })
        },
        Law {
            place: Place::Parameter,
            ..law(
                "parameter-error",
                "relative",
                "parameter",
                (Matched, Nothing),
                [0.05, 1.2],
                |s| {
                    let factor =
                        if s.sign() < 0.0 { 1.0 / (1.0 + s.strength) } else { 1.0 + s.strength };
                    Mechanism::Factor(Box::new(move |_| factor))
                },
            )
        },
    ]
}

/// Amplitude, angular frequency and phase of a periodic force.
fn wave(s: &Setting<'_>) -> (f64, f64, f64) {
    let (slow, fast): (f64, f64) = (2.0 / s.scales.duration, 0.1 / s.scales.ts);
    let frequency = slow * (fast / slow).powf(s.shape[1]);
    let turn = std::f64::consts::TAU;
    (unit_force(s), turn * frequency, turn * s.shape[2])
}

#[allow(clippy::too_many_lines, reason = "a table of laws")]
fn memories_and_limits() -> Vec<Law> {
    use Needs::{Level, Motion, Reversal};
    use Origin::{Matched, Mismatch};
    let (rubs, bound) = ("friction", "limit");
    vec![
        law("hysteresis", "dahl", rubs, (Matched, Reversal), [3e-3, 0.6], |s| {
            let (f, length) = bristle(s);
            memory(
                1,
                move |at, z| at.against(f * z[0]),
                move |at, z, dz| dz[0] = at.v / length * (1.0 - z[0] * at.v.signum()),
            )
        }),
        law("hysteresis", "bouc-wen", rubs, (Matched, Reversal), [3e-3, 0.6], |s| {
            let (f, length) = bristle(s);
            memory(
                1,
                move |at, z| at.against(f * z[0]),
                move |at, z, dz| {
                    dz[0] = at.v / length * if z[0] * at.v > 0.0 { 1.0 - z[0].abs() } else { 1.0 };
                },
            )
        }),
        law("hysteresis", "sharp", rubs, (Mismatch, Reversal), [3e-3, 0.6], |s| {
            let (f, length) = bristle(s);
            memory(
                1,
                move |at, z| at.against(f * z[0]),
                move |at, z, dz| {
                    let held = z[0].abs().powi(4) * if z[0] * at.v > 0.0 { 1.0 } else { 0.2 };
                    dz[0] = at.v / length * (1.0 - held);
                },
            )
        }),
        law("hysteresis", "bristles-and-damping", rubs, (Mismatch, Reversal), [3e-3, 0.5], |s| {
            let (f, length) = bristle(s);
            let (slow, usual) = (0.2 * s.velocity(), s.velocity());
            // LuGre: Stribeck curve behind the bristles, and damping.
            let level = move |v: f64| 1.0 + 0.7 * (-(v / slow).powi(2)).exp();
            memory(
                1,
                move |at, z| at.against(f * (z[0] + 0.1 * at.v / usual)),
                move |at, z, dz| dz[0] = (at.v - at.v.abs() * z[0] / level(at.v)) / length,
            )
        }),
        law(
            "resonant-mode",
            "appendage",
            "resonance",
            (Matched, Needs::Carrier),
            [3e-3, 0.8],
            |s| appendage(s, 0.0),
        ),
        law(
            "resonant-mode",
            "hardening",
            "resonance",
            (Mismatch, Needs::Carrier),
            [3e-3, 0.8],
            |s| appendage(s, 1.0),
        ),
        law("end-stop", "both", bound, (Matched, Motion), [5e-3, 0.6], |s| {
            let (middle, reach, k) = stop(s);
            force(move |at| {
                let d = at.x - middle;
                at.against(k * (d - d.clamp(-reach, reach)))
            })
        }),
        law("end-stop", "one", bound, (Matched, Motion), [5e-3, 0.6], |s| {
            let ((middle, reach, k), sign) = (stop(s), s.sign());
            force(move |at| at.against(sign * k * (sign * (at.x - middle) - reach).max(0.0)))
        }),
        law("end-stop", "wall", bound, (Mismatch, Motion), [5e-3, 0.5], |s| {
            let (middle, reach, _) = stop(s);
            Mechanism::Wall { low: middle - reach, high: middle + reach, restitution: 0.4 }
        }),
        law("overflow", "lost", bound, (Matched, Level), [5e-3, 0.6], |s| Mechanism::Brim {
            brim: brim(s),
            share: 0.0,
        }),
        law("overflow", "weir", bound, (Mismatch, Level), [5e-3, 0.6], |s| {
            let (brim, f) = (brim(s), 4.0 * s.site().force);
            let width = 0.2 * s.position();
            force(move |at| at.against(f * ((at.x - brim).max(0.0) / width).powf(1.5)))
        }),
    ]
}

/// Level and length of presliding.
fn bristle(s: &Setting<'_>) -> (f64, f64) {
    (unit_force(s), s.position() * 0.05 * 20.0_f64.powf(s.shape[1]))
}

/// A mass on a spring, carried by the site; `stiffening` is that of its spring.
fn appendage(s: &Setting<'_>, stiffening: f64) -> Mechanism {
    let (share, damping) = (s.strength, s.shape(2, 0.02, 0.15));
    let (slow, fast): (f64, f64) = (5.0 / s.scales.duration, 0.1 / s.scales.ts);
    let w = std::f64::consts::TAU * slow * (fast / slow).powf(s.shape[1]);
    // Displacement that the usual acceleration makes.
    let usual = s.site().acceleration / (w * w);
    let pull = move |z: &[f64]| {
        w * w * z[0] * (1.0 + stiffening * (z[0] / usual).powi(2)) + 2.0 * damping * w * z[1]
    };
    Mechanism::Force {
        states: 2,
        accelerated: true,
        force: Box::new(move |at, z| share * pull(z) / at.c),
        rates: Box::new(move |at, z, dz| {
            dz[0] = z[1];
            dz[1] = -at.a - (1.0 + share) * pull(z);
        }),
    }
}

/// Middle, reach and stiffness of a stop.
fn stop(s: &Setting<'_>) -> (f64, f64, f64) {
    let (low, high) = s.site().position.as_ref().map_or((0.0, 0.0), |p| (p.low, p.high));
    let stiffness = s.shape(1, 8.0, 30.0) * s.site().force / s.position();
    (0.5 * (low + high), 0.5 * (high - low) * (1.0 - s.strength), stiffness)
}

fn brim(s: &Setting<'_>) -> f64 {
    let (low, high) = s.site().position.as_ref().map_or((0.0, 0.0), |p| (p.low, p.high));
    high - s.strength * (high - low)
}
