//! Example models, candidates written by hand, and logs of a reality with a law of its own.

use std::path::Path;

use fd_effect::{Candidate, EffectParameter, Kind, Side, SiteRef};
use fd_model::{
    Record, SampleTime,
    signal::{ArNoise, WhiteNoise},
};
use fd_sim::{
    equation::Expr,
    model::{Delay, Model, Parameter},
    patch::Patch,
    simulate::{EquationSimulator, Simulator},
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

pub(crate) fn example(name: &str) -> Model {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/models");
    Model::load(&root.join(format!("{name}.toml"))).unwrap()
}

pub(crate) fn expr(text: &str) -> Expr {
    Expr::parse(text).unwrap()
}

/// One unknown strength `a` (and perhaps a second one), spliced in by `splice`.
pub(crate) struct Recipe<'a> {
    pub(crate) label: &'static str,
    pub(crate) family: &'static str,
    pub(crate) site: SiteRef,
    pub(crate) side: Side,
    /// Scale, low, high, neutral.
    pub(crate) strength: [f64; 4],
    pub(crate) starts: &'a [f64],
}

pub(crate) fn candidate(
    model: &Model,
    recipe: Recipe<'_>,
    splice: impl Fn(&mut Patch),
) -> Candidate {
    let Recipe { label, family, site, side, strength, starts } = recipe;
    let [scale, low, high, neutral] = strength;
    let simulator = EquationSimulator::<f64>::new(model).unwrap();
    let mut patch = Patch::of(model);
    patch.add_parameter(Parameter::new("a", "1", neutral));
    patch.pin_step(model.sample_time / simulator.substeps() as f64);
    splice(&mut patch);
    let parameter = EffectParameter {
        is_native: false,
        name: "a".into(),
        unit: "1".into(),
        scale,
        low,
        high,
        neutral,
        is_strength: true,
        is_reciprocal: false,
        in_another_run: fd_effect::InAnotherRun::Same,
    };
    Candidate {
        label,
        law: "simple",
        family,
        site,
        partner: None,
        side,
        kind: Kind::Simulation,
        model: patch.finish().unwrap(),
        parameters: vec![parameter],
        starts: starts.iter().map(|start| vec![*start]).collect(),
        spectral: None,
        rounding: None,
    }
}

/// A library of a dozen effects at the places of a model; `u`, `f`, `v`, `y` are the sizes of
/// inputs, forces, velocities and outputs.
pub(crate) fn candidates(model: &Model, size: impl Fn(&str) -> f64) -> Vec<Candidate> {
    let mut all = Vec::new();
    for (i, input) in model.inputs.iter().enumerate() {
        let (u, us) = (&input.name, size(&input.name));
        let site = || SiteRef::Input(i, u.clone());
        let mut add = |label, family, strength, starts: &[f64], value: String| {
            let recipe =
                Recipe { label, family, site: site(), side: Side::Input, strength, starts };
            all.push(candidate(model, recipe, |patch| {
                patch.wrap_input(u, "applied", expr(&value)).unwrap();
            }));
        };
        add("gain", "actuator-gain", [0.05, -0.9, 2.0, 0.0], &[0.05], format!("{u}*(1 + a)"));
        add("offset", "offset", [0.1 * us, -us, us, 0.0], &[0.1 * us], format!("{u} + a"));
        add(
            "dead-zone",
            "actuator-nonlinearity",
            [0.1 * us, 0.0, 0.95 * us, 0.0],
            &[0.02 * us, 0.08 * us, 0.2 * us, 0.45 * us],
            format!("{u} - clamp({u}, -a, a)"),
        );
        let full = 1.5 * us;
        add(
            "saturation",
            "actuator-nonlinearity",
            [0.1, 0.0, 12.0, 0.0],
            &[1.1, 1.6, 2.5].map(|x| x / 1.5),
            format!("{u}/max(1, a*abs({u})/{full})"),
        );
        let dt = model.sample_time;
        let recipe = Recipe {
            label: "delay",
            family: "late",
            site: site(),
            side: Side::Input,
            strength: [dt, 0.0, 60.0 * dt, 0.0],
            starts: &[0.5 * dt, 2.0 * dt, 6.0 * dt, 15.0 * dt],
        };
        all.push(candidate(model, recipe, |patch| {
            patch.wrap_input(u, "applied", expr("late")).unwrap();
            let (value, time) = (expr(u), expr("a"));
            patch.add_delay(Delay { name: "late".into(), value, time });
        }));
    }
    for (i, site) in model.sites.iter().enumerate() {
        let Some(velocity) = &site.velocity else { continue };
        let (fs, vs) = (size(&site.name), size("v"));
        let v = format!("({velocity})");
        let mut add = |label, family, strength, starts: &[f64], value: String| {
            let name = SiteRef::Force(i, site.name.clone());
            let recipe =
                Recipe { label, family, site: name, side: Side::Dynamics, strength, starts };
            all.push(candidate(model, recipe, |patch| {
                patch.add_force(&site.name, "effect", expr(&value)).unwrap();
            }));
        };
        let tanh = format!("-a*tanh({v}/{})", 0.02 * vs);
        let starts = [0.05, 0.3, 0.8].map(|x| x * fs);
        add("coulomb", "friction", [0.1 * fs, 0.0, 3.0 * fs, 0.0], &starts, tanh);
        let scale = 0.1 * fs / vs;
        let viscous = format!("-a*{v}");
        add("viscous", "friction", [scale, -10.0 * scale, 40.0 * scale, 0.0], &[scale], viscous);
        let scale = 0.1 * fs / vs / vs;
        let drag = format!("-a*abs({v})*{v}");
        add("drag", "friction", [scale, 0.0, 40.0 * scale, 0.0], &[scale], drag);
        add("load", "offset", [0.1 * fs, -3.0 * fs, 3.0 * fs, 0.0], &[0.1 * fs], "a".into());
        if let Some(position) = &site.position {
            let scale = 0.1 * fs / size("x").powi(3);
            let cubic = format!("-a*({position})^3");
            add("cubic", "stiffness", [scale, -5.0 * scale, 40.0 * scale, 0.0], &[scale], cubic);
        }
    }
    for (i, output) in model.outputs.iter().enumerate() {
        let ys = size(&output.name);
        let mut add = |label, family, strength, starts: &[f64], value: String| {
            let site = SiteRef::Output(i, output.name.clone());
            let recipe = Recipe { label, family, site, side: Side::Output, strength, starts };
            all.push(candidate(model, recipe, |patch| {
                patch.wrap_output(&output.name, "measured", expr(&value)).unwrap();
            }));
        };
        add(
            "bias",
            "offset",
            [0.1 * ys, -3.0 * ys, 3.0 * ys, 0.0],
            &[0.1 * ys],
            "measured + a".into(),
        );
        let drift = "measured + a*t".to_owned();
        let rate = 0.1 * ys / (1000.0 * model.sample_time);
        add("drift", "drift", [rate, -30.0 * rate, 30.0 * rate, 0.0], &[rate], drift);
        add("scale", "sensor-gain", [0.05, -0.9, 2.0, 0.0], &[0.05], "measured*(1 + a)".into());
    }
    all
}

/// Sizes of the signals of two example models under [`excitation`].
pub(crate) fn sizes(model: &str) -> impl Fn(&str) -> f64 + '_ {
    move |what| match (model, what) {
        ("mass_spring_damper", "force" | "carriage") => 6.0,
        ("mass_spring_damper", "v") => 0.6,
        ("mass_spring_damper", "x" | "position") => 0.1,
        ("dc_drive", "u") => 12.0,
        ("dc_drive", "shaft") => 0.2,
        ("dc_drive", "v" | "speed") => 100.0,
        ("dc_drive", "current") => 5.0,
        (_, other) => panic!("no size of {other} in {model}"),
    }
}

/// Steps of random height held for 5 to 40 samples.
pub(crate) fn excitation(amplitude: f64, samples: usize, seed: u64) -> Vec<f64> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut u = Vec::with_capacity(samples + 40);
    while u.len() < samples {
        let level = amplitude * random.random_range(-1.0..1.0);
        let hold = random.random_range(5..40_usize);
        u.extend(std::iter::repeat_n(level, hold));
    }
    u.truncate(samples);
    u
}

/// How reality differs from the model besides its effect.
#[derive(Clone, Copy)]
pub(crate) struct Reality {
    pub(crate) samples: usize,
    pub(crate) amplitude: f64,
    /// Parameters are drawn within this part of their value.
    pub(crate) parameter_error: f64,
    /// Coefficient of first-order noise; 0 is white.
    pub(crate) colour: f64,
    pub(crate) seed: u64,
}

/// A log of a patched model, integrated eight times finer, from an unknown initial state, with
/// parameter errors and noise.
pub(crate) fn record(model: &Model, reality: Reality, excitation_seed: u64) -> Record {
    let Reality { samples, amplitude, parameter_error, colour, seed } = reality;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let ts = SampleTime::new(model.sample_time).unwrap();
    let mut simulator = EquationSimulator::<f64>::new(model).unwrap().refined(8);
    let known = |p: &Parameter| {
        let error = parameter_error.min(p.tolerance) * random.random_range(-1.0..1.0);
        if p.name.starts_with("true_") { p.value } else { p.value * (1.0 + error) }
    };
    let theta: Vec<f64> = model.parameters.iter().map(known).collect();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed + excitation_seed + 1000);
    let x0: Vec<f64> = model
        .all_states()
        .map(|s| s.initial + s.tolerance.unwrap_or(0.0) * random.random_range(-1.0..1.0))
        .collect();
    let inputs = model.external_inputs();
    let columns: Vec<Vec<f64>> = (0..inputs.len())
        .map(|i| excitation(amplitude, samples, excitation_seed + 77 * i as u64))
        .collect();
    let u: Vec<f64> =
        (0..samples).flat_map(|k| columns.iter().map(move |column| column[k])).collect();
    let mut y = vec![0.0; samples * model.outputs.len()];
    Simulator::simulate(&mut simulator, &theta, &x0, &u, &mut y);
    for (c, output) in model.outputs.iter().enumerate() {
        let noise_seed = seed + excitation_seed * 31 + c as u64;
        let sigma = output.noise.unwrap();
        let noise = if colour.abs() > 0.0 {
            ArNoise::new(vec![colour], sigma, noise_seed).values(samples).unwrap()
        } else {
            WhiteNoise::new(sigma, noise_seed).values(samples).unwrap()
        };
        y.iter_mut().skip(c).step_by(model.outputs.len()).zip(noise).for_each(|(y, e)| *y += e);
    }
    Record::new(inputs, model.output_channels(), u, y, ts).unwrap()
}
