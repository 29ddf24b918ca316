//! Catch-all maps: a free curve at a site, for causes whose law no effect knows.
//!
//! A map is the sum of six hat functions on an even grid over the range that its argument has in
//! the nominal simulation; beyond the range it stays at its last value. It says where something is
//! missing and what it depends on, not what it is. *When not to use:* as a cause with a name; its
//! six strengths fit nearly anything static, and need a prior of their own.

use fd_sim::model::Model;
use fd_sim::scales::{ForceScale, ReplayScales, SignalScale};

use super::{Candidate, Effect, InAnotherRun, Offers, Reason, Sketch, dynamics::mentions};

/// Number of hat functions.
const HATS: u8 = 6;
/// Size of a hat at its start, in units of its scale.
const START: f64 = 0.1;

/// What arrives is the input plus a curve of the input, or of time.
#[derive(Clone, Copy, Debug)]
pub struct InputMap;

/// A force that is a curve of the velocity, the position, or time.
#[derive(Clone, Copy, Debug)]
pub struct ForceMap;

/// The sensor shows the output plus a curve of the output, or of time.
#[derive(Clone, Copy, Debug)]
pub struct SensorMap;

/// All effects that are maps.
///
/// ```
/// assert_eq!(fd_effect::map::all()[0].label(), "input-map");
/// ```
#[must_use]
pub fn all() -> Vec<Box<dyn Effect>> {
    vec![Box::new(InputMap), Box::new(ForceMap), Box::new(SensorMap)]
}

impl Effect for InputMap {
    fn label(&self) -> &'static str {
        "input-map"
    }

    fn family(&self) -> &'static str {
        "map"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn has_slope(&self) -> bool {
        false
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let offers = scales.inputs.iter().enumerate().flat_map(|(i, input)| {
            [("of-input", "u", range(input)), ("of-time", "t", [0.0, scales.duration])].map(
                |(law, of, range)| {
                    let sketch = Sketch::of_input(self, law, nominal, scales, i)
                        .require(input.moves(), Reason::Still("the input"))
                        .require(mentions(nominal, &nominal.inputs[i].name), Reason::Idle);
                    curve(sketch, &input.unit, input.std, of, range)
                        .wrap_input("u + curve")
                        .in_another_run(in_another_run(of))
                        .finish()
                },
            )
        });
        let signals = scales.signals.iter().enumerate().filter(|(_, signal)| signal.moves());
        let signals = signals.map(|(i, signal)| {
            let sketch = Sketch::of_signal(self, "of-input", nominal, scales, i);
            curve(sketch, &signal.unit, signal.std, "u", range(signal))
                .wrap_input("u + curve")
                .finish()
        });
        offers.chain(signals).collect()
    }
}

impl Effect for ForceMap {
    fn label(&self) -> &'static str {
        "force-map"
    }

    fn family(&self) -> &'static str {
        "map"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn has_slope(&self) -> bool {
        false
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let offers = scales.sites.iter().enumerate().flat_map(|(i, site)| {
            let ForceScale { velocity, position, .. } = site;
            let signal = |signal: &Option<(_, SignalScale)>| {
                signal.as_ref().map(|(_, scale)| scale).filter(|scale| scale.moves()).map(range)
            };
            [
                ("of-velocity", "v", signal(velocity), "velocity that moves"),
                ("of-position", "x", signal(position), "position that moves"),
                ("of-time", "t", Some([0.0, scales.duration]), "time"),
            ]
            .map(|(law, of, range, missing)| {
                let sketch = Sketch::of_force(self, law, nominal, scales, i)
                    .require(site.force > 0.0, Reason::Still("what the force would move"))
                    .require(range.is_some(), Reason::Missing(missing));
                let range = range.unwrap_or([0.0, 1.0]);
                curve(sketch, &site.unit, site.force, of, range)
                    .force("map", "curve")
                    .in_another_run(in_another_run(of))
                    .finish()
            })
        });
        offers.collect()
    }
}

impl Effect for SensorMap {
    fn label(&self) -> &'static str {
        "sensor-map"
    }

    fn family(&self) -> &'static str {
        "map"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn has_slope(&self) -> bool {
        false
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let offers = scales.outputs.iter().enumerate().flat_map(|(i, output)| {
            [("of-output", "y", range(output)), ("of-time", "t", [0.0, scales.duration])].map(
                |(law, of, range)| {
                    let sketch = Sketch::of_output(self, law, nominal, scales, i)
                        .require(output.moves(), Reason::Still("the output"));
                    curve(sketch, &output.unit, output.std, of, range)
                        .wrap_output("y + curve")
                        .in_another_run(in_another_run(of))
                        .finish()
                },
            )
        });
        offers.collect()
    }
}

/// The mechanism that a candidate speaks for: its family, and for a map that of the named laws
/// which depend on the same quantity.
///
/// ```
/// # use fd_effect::{EverySite, Suspects, library, map::mechanism};
/// # use fd_sim::{scales::ReplayScales, model::Model};
/// # let model: Model = r#"
/// # version = 1
/// # kind = "equations"
/// # name = "slider"
/// # sample_time = 0.01
/// # inputs = { u = { unit = "N" } }
/// # states = { v = { unit = "m/s", initial = 0.0, derivative = "u" } }
/// # outputs = { y = { unit = "m/s", value = "v" } }
/// # sites = { rail = { unit = "N", enters = { v = "1" }, velocity = "v" } }
/// # "#.parse()?;
/// # let u: Vec<f64> = (0..100).map(|k| if k < 50 { 3.0 } else { -3.0 }).collect();
/// # let scales = ReplayScales::of(&model, model.sample_time()?, &u, 100)?;
/// let all = EverySite::new(library(), &model, scales).alone();
/// let map = all.iter().flatten().find(|c| (c.label, c.law) == ("force-map", "of-velocity"));
/// assert_eq!(mechanism(map.unwrap()), "friction");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn mechanism(candidate: &Candidate) -> &'static str {
    match (candidate.label, candidate.law) {
        ("input-map", "of-time") => "actuator-offset",
        ("input-map", _) => "actuator-nonlinearity",
        ("force-map", "of-velocity") => "friction",
        ("force-map", "of-position") => "stiffness",
        ("force-map", _) => "load",
        ("sensor-map", "of-time") => "sensor-offset",
        ("sensor-map", _) => "sensor-nonlinearity",
        _ => candidate.family,
    }
}

/// A curve of time is the path of one run, any other one a property of the plant.
fn in_another_run(of: &str) -> InAnotherRun {
    if of == "t" { InAnotherRun::Path } else { InAnotherRun::Same }
}

fn range(signal: &SignalScale) -> [f64; 2] {
    [signal.low, signal.high]
}

/// Adds the strengths of the hats and `curve`, a curve of the template `of`. Each start has one
/// hat.
pub(super) fn curve<'a>(
    sketch: Sketch<'a>,
    unit: &str,
    scale: f64,
    of: &str,
    range: [f64; 2],
) -> Sketch<'a> {
    let hats = curve_of(HATS, sketch, unit, scale, of, range);
    (0..HATS).fold(hats, |sketch, i| sketch.start(&one_hat(HATS, i)))
}

/// A start with one of so many hats.
pub(super) fn one_hat(hats: u8, which: u8) -> Vec<f64> {
    (0..hats).map(|i| if i == which { START } else { 0.0 }).collect()
}

/// The same with so many hats, and without any start.
pub(super) fn curve_of<'a>(
    hats: u8,
    sketch: Sketch<'a>,
    unit: &str,
    scale: f64,
    of: &str,
    [low, high]: [f64; 2],
) -> Sketch<'a> {
    let distance = (high - low) / f64::from(hats - 1);
    let mut sketch = sketch.bind("low", low).bind("high", high).bind("distance", distance).define(
        "q",
        "map_argument",
        &format!("clamp({of}, low, high)"),
    );
    let mut sum = Vec::new();
    for i in 0..hats {
        sketch = sketch
            .strength(&format!("h_{i}"), &format!("map_{}", i + 1), unit, scale, [-3.0, 3.0])
            .bind(&format!("c_{i}"), low + f64::from(i) * distance);
        sum.push(format!("h_{i}*max(0, 1 - abs(q - c_{i})/distance)"));
    }
    sketch.define("curve", "map_value", &sum.join(" + "))
}
