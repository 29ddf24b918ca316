//! An elastic transmission: a gear, a belt, a coupling, a shaft that gives way.

use fd_sim::{equation::Expr, model::Model, scales::ReplayScales};

use super::{
    dependence::variables,
    sites::{NO_EQUATION, SiteUnits, each_site},
};
use crate::{Effect, Offers, Reason, SiteRef, Sketch, units::per};

/// Frequencies of the coarse grid from which to start.
const FREQUENCIES: u8 = 12;
/// Highest of them, in sample rates: what swings faster is seen through its aliases only.
const HIGHEST: f64 = 0.2;
/// Share of the inertia on the other side from which to start.
const SHARE: f64 = 0.3;
/// Damping ratio from which to start.
const DAMPING: f64 = 0.1;

/// A spring and a damper between two bodies where the model has one rigid body: they swing against each other with the
/// frequency `f` and the damping ratio `z`. The strength is `s = 1/f`, so that a rigid transmission is exactly none.
///
/// * `split`: the inputs drive a share `r` of the inertia (the rotor), everything else acts on the other share (the load), which
///   is what the model shows.
/// * `added`: the rotor has `j` times the inertia of the model, which is that of the load.
/// * `before-the-sensor`: everything acts on the share `1 - r`, and outputs show the share `r` behind the spring.
///
/// With the acceleration `a` of the rigid model, `h` the part of it that does not come from inputs, and `T = s/2π`, the
/// deflection is `T² q`, where `T² q'' + 2 z T q' + q = g`. The load is moved by `-T² q''` beyond the rigid model, for
/// `g = a - h/(1 - r)`; with an added rotor by that and `-a j/(1 + j)`, for `g = a/(1 + j) - h`; before a sensor
/// `g = a/(1 - r)`, the driven body is moved by `r T² q''`, and outputs are behind by `T² q`.
///
/// The oscillator is exact over an integration step for a held `g`, however stiff it is, and the bodies receive its mean over
/// the step; for what changes within a step the error shrinks with the square of the step. A run starts with the
/// deflection that its first load makes.
#[derive(Clone, Copy, Debug)]
pub struct ElasticTransmission;

impl Effect for ElasticTransmission {
    fn label(&self) -> &'static str {
        "elastic-transmission"
    }

    fn family(&self) -> &'static str {
        "resonance"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let (lowest, highest) = (2.0 / scales.duration, HIGHEST / scales.ts);
        let frequency =
            |i: u8| lowest * (highest / lowest).powf((f64::from(i) + 0.5) / f64::from(FREQUENCIES));
        // The stiffest first: it changes least.
        let grid: Vec<f64> = (0..FREQUENCIES).rev().map(frequency).collect();
        let starts = |share: f64| grid.iter().map(move |f| [1.0 / f, share, DAMPING]);
        each_site(self, nominal, scales, |sketch, at| {
            let (unforced, helpers) = at.site.unforced(nominal);
            let spring = |law| {
                sketch(law)
                    .with_velocity(at)
                    .require(at.has_velocity(), Reason::Missing("velocity"))
                    .require(at.site.has_equation(), NO_EQUATION)
                    .with_helpers(&at.site.helpers)
                    .with_helpers(&helpers)
                    .bind("a", at.site.acceleration.clone())
                    .bind("C", at.site.compliance.clone())
                    .bind("h", unforced.clone())
                    .limit("s", "resonance", per("1", "Hz"), 1.0, [0.0, 1.0 / lowest])
            };
            let share =
                |law| spring(law).shape("r", "share_of_inertia", "1", 1.0, [0.0, 0.95], SHARE);
            let split = ["a - h/(1 - r)", "a + b - (h + b)/(1 - r)"];
            let split = swing(share("split"), at, split).force("transmission", "-T*kick/(dt*C)");
            let added = spring("added").strength("j", "added_inertia", "1", 1.0, [0.0, 5.0]);
            let added = swing(added, at, ["a/(1 + j) - h", "(a + b)/(1 + j) - (h + b)"])
                .force("transmission", "-(T*kick/dt + a*j/(1 + j))/C");
            let sensor = share("before-the-sensor");
            let sensor = swing(sensor, at, ["a/(1 - r)", "(a + b)/(1 - r)"])
                .force("transmission", "r*T*kick/(dt*C)");
            let sensor = behind(sensor, nominal, at);
            vec![
                split.starts(starts(SHARE)),
                added.starts(starts(SHARE)),
                sensor.starts(starts(SHARE)),
            ]
        })
    }
}

/// Adds the oscillator that `g` drives: its deflection `q`, its rate `w` in units of that, and `kick`, by how much the rate
/// changes in the step. The templates are `g` at a time, and its mean over a step, in which `h` has grown by `b` if it goes on
/// as in the step before.
fn swing<'a>(sketch: Sketch<'a>, at: &SiteUnits<'_>, [now, mean]: [&str; 2]) -> Sketch<'a> {
    let unit = per(&at.velocity_unit(), "s");
    sketch
        .shape("z", "transmission_damping", "1", 1.0, [1e-3, 0.95], DAMPING)
        .abbreviate("T", "s/(2*pi)")
        .abbreviate("p", "dt/max(T, dt/1000)")
        .abbreviate("n", "sqrt(1 - z^2)")
        .abbreviate("E", "exp(-z*p)")
        .abbreviate("c", "cos(n*p)")
        .abbreviate("S", "sin(n*p)/n")
        .memory("q", "deflection", &unit, now)
        .memory("w", "deflection_rate", &unit, "0")
        .memory("o", "load_before", &unit, "h")
        .abbreviate("b", "0.5*(h - o)")
        .define("g", "drives_apart", now)
        .define("G", "drives_apart_mean", mean)
        .define("kick", "rate_change", "E*((c - z*S)*w - S*(q - g)) - w")
        .becomes("o", "h")
        .becomes("q", "G + E*((c + z*S)*(q - G) + S*w)")
        .becomes("w", "E*((c - z*S)*w - S*(q - G))")
}

/// Shows position and velocity of the site as they are behind the spring, in every output that depends on them.
fn behind<'a>(mut sketch: Sketch<'a>, nominal: &Model, at: &SiteUnits<'_>) -> Sketch<'a> {
    let state = |signal: &Option<(Expr, _)>| match signal {
        Some((Expr::Name(name), _)) => Some(name.clone()),
        _ => None,
    };
    let moved = [(state(&at.site.position), "T^2*q"), (state(&at.site.velocity), "T*w")];
    let moved = moved.into_iter().filter_map(|(name, by)| Some((name?, by)));
    let moved: Vec<(String, &str)> = moved.collect();
    let mut is_shown = false;
    for (i, output) in nominal.outputs.iter().enumerate() {
        let depends = depends_on(nominal, &output.value, &moved);
        is_shown |= depends;
        if depends {
            let site = SiteRef::Output(i, output.name.clone());
            sketch = sketch.shift_output(&site, nominal, &moved);
        }
    }
    sketch.require(is_shown, Reason::Missing("output of its motion"))
}

fn depends_on(nominal: &Model, value: &Expr, moved: &[(String, &str)]) -> bool {
    let variables = variables(nominal, value);
    moved.iter().any(|(name, _)| variables.contains(name.as_str()))
}
