//! Effects of one's own, as text.

use fd_effect::{
    Candidate, Effect,
    text::{TextEffect, TextEffects},
};
use fd_sim::{
    model::Model,
    scales::ReplayScales,
    simulate::{EquationSimulator, Simulator},
};

fn slider() -> Model {
    r#"
    version = 1
    kind = "equations"
    name = "slider"
    sample_time = 0.01
    inputs = { force = { unit = "N" }, heat = { unit = "K" } }
    outputs = { speed = { unit = "m/s", value = "v" } }
    sites = { rail = { unit = "N", enters = { v = "1/m" }, velocity = "v" } }
    [parameters]
    m = { unit = "kg", value = 2.0, tolerance = 0.05 }
    d = { unit = "N s/m", value = 0.5, tolerance = 0.05 }
    [states]
    v = { unit = "m/s", initial = 0.0, derivative = "(force - d*v)/m" }
    "#
    .parse()
    .unwrap()
}

fn inputs() -> Vec<f64> {
    let row = |k: u32| [2.0 * (0.05 * f64::from(k)).sin(), 20.0 + 0.1 * f64::from(k)];
    (0..300).flat_map(row).collect()
}

fn scales(model: &Model) -> ReplayScales {
    ReplayScales::of(model, model.sample_time().unwrap(), &inputs(), 300).unwrap()
}

fn read(json: &str) -> Result<TextEffect, String> {
    let effects: TextEffects = serde_json::from_str(json).map_err(|e| e.to_string())?;
    let effect = effects.effects().map_err(|e| e.to_string())?.remove(0);
    effect.check(&slider()).map_err(|e| e.to_string())?;
    Ok(effect)
}

fn one(json: &str) -> Candidate {
    let effect = read(json).unwrap();
    let model = slider();
    let mut all = effect.candidates(&model, &scales(&model));
    assert_eq!(all.len(), 1);
    all.remove(0).unwrap()
}

/// Outputs with these values of the effect.
fn outputs(model: &Model, values: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; 300];
    let theta = [&slider().nominal()[..], values].concat();
    let mut simulator = EquationSimulator::<f64>::new(model).unwrap();
    Simulator::simulate(&mut simulator, &theta, &model.initial(), &inputs(), &mut y);
    y
}

#[test]
fn at_each_side_a_law_is_nothing_at_zero_and_what_it_says_above() {
    let nominal = outputs(&slider(), &[]);
    let a = r#""parameters": {"a": {"size": 0.1, "unit": "N"}}"#;
    let of = |side: &str, at: &str, law: &str| {
        format!(r#"{{"own": {{"side": "{side}", "at": ["{at}"], "law": "{law}", {a}}}}}"#)
    };
    for (side, at, law) in [
        ("input", "force", "u*(1 + a*heat/20)"),
        ("force", "rail", "-a*v*abs(v)"),
        ("output", "speed", "y + a*sin(3*t)"),
        ("parameter", "d", "p*(1 + a*heat)"),
    ] {
        let candidate = one(&of(side, at, law));
        assert_eq!(
            (candidate.label, candidate.family, candidate.site.name()),
            ("own", "own", Some(at))
        );
        assert_eq!(candidate.parameters[0].name, format!("{at}_a"));
        assert_eq!(candidate.starts, [[0.1]], "from one size; not below the bound of 0");
        assert_eq!(outputs(&candidate.model, &[0.0]), nominal, "{side}");
        assert_ne!(outputs(&candidate.model, &[0.5]), nominal, "{side}");
    }
    // By hand: what the sensor shows is moved by what the text says.
    let shown = outputs(&one(&of("output", "speed", "y + a*sin(3*t)")).model, &[0.5]);
    for (k, (shown, y)) in shown.iter().zip(&nominal).enumerate() {
        let expected = y + 0.5 * (3.0 * 0.01 * k as f64).sin();
        // Rounding of the time of a sample.
        assert!((shown - expected).abs() < 1e-12, "{k}: {shown}, {expected}");
    }
}

#[test]
fn states_shapes_and_starts() {
    let candidate = one(
        r#"{"warm-up": {"side": "input", "at": ["force"], "family": "actuator-gain",
            "law": "u*(1 - a*z)",
            "states": {"z": {"derivative": "(1 - z)/T", "unit": "1"}},
            "parameters": {"a": {"size": 0.1, "bounds": [-0.5, 0.5]},
                           "T": {"size": 0.2, "shape": 1.0, "bounds": [0.1, 5], "unit": "s", "starts": [3.0]}}}}"#,
    );
    assert_eq!(candidate.family, "actuator-gain");
    let names: Vec<&str> = candidate.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["force_T", "force_a"]);
    assert_eq!(
        candidate.parameters.iter().map(|p| p.is_strength).collect::<Vec<_>>(),
        [false, true]
    );
    // T at 3 and at 1, a at plus and minus a size.
    assert_eq!(candidate.starts, [[3.0, 0.1], [3.0, -0.1], [1.0, 0.1], [1.0, -0.1]]);
    // With z = 1 - exp(-t/T) the force fades: less speed at the end of the first push than without.
    let (faded, plain) = (outputs(&candidate.model, &[1.0, 0.5]), outputs(&slider(), &[]));
    assert!(faded[60] < plain[60] && 0.5 * plain[60] < faded[60]);
}

#[test]
fn without_a_place_it_is_everywhere_and_says_where_it_cannot_be() {
    let everywhere =
        read(r#"{"own": {"side": "input", "law": "u + a", "parameters": {"a": {"size": 1}}}}"#)
            .unwrap();
    let model = slider();
    assert_eq!(everywhere.candidates(&model, &scales(&model)).len(), 2);
    let of_position =
        read(r#"{"own": {"side": "force", "law": "-a*x", "parameters": {"a": {"size": 1}}}}"#)
            .unwrap();
    let refused = of_position.candidates(&model, &scales(&model)).remove(0).unwrap_err();
    assert_eq!(refused.to_string(), "own (text) cannot be tested here: the site has no position");
}

#[test]
fn what_is_wrong_is_said_with_the_nearest_name() {
    let a = r#""parameters": {"a": {"size": 1}}"#;
    for (json, message) in [
        (format!(r#"{{"Own law": {{"side": "input", "law": "u", {a}}}}}"#), "effect `Own law`: label: expected a word"),
        (format!(r#"{{"drag": {{"side": "force", "law": "a", {a}}}}}"#), "expected a label that no effect of the library has"),
        (format!(r#"{{"own": {{"side": "input", "at": ["forse"], "law": "u", {a}}}}}"#), "at: expected a name of the model or the effect; did you mean `force`?, found `forse`"),
        (format!(r#"{{"own": {{"side": "input", "law": "u*(1 + a*heaat)", {a}}}}}"#), "law: expected a name of the model or the effect; did you mean `heat`?, found `heaat`"),
        (format!(r#"{{"own": {{"side": "input", "law": "u*(1 + a", {a}}}}}"#), "effect `own`: law: "),
        (format!(r#"{{"own": {{"side": "input", "law": "1.1*u + a", {a}}}}}"#), "law: expected `u` where all strengths are 0, found"),
        (format!(r#"{{"own": {{"side": "force", "law": "a - v", {a}}}}}"#), "law: expected `0` where all strengths are 0, found"),
        (r#"{"own": {"side": "input", "law": "u", "parameters": {}}}"#.to_owned(), "parameters: expected a strength, and at most 8"),
        (r#"{"own": {"side": "input", "law": "u", "parameters": {"u": {"size": 1}}}}"#.to_owned(), "means nothing else there, found `u`"),
        (r#"{"own": {"side": "input", "law": "u + a", "parameters": {"a": {"size": 0}}}}"#.to_owned(), "parameters.a.size: expected a change that is noticed, above 0, found 0"),
        (r#"{"own": {"side": "input", "law": "u + a", "parameters": {"a": {"size": 1, "bounds": [1, 2]}}}}"#.to_owned(), "parameters.a.bounds: expected finite ones around 0, found [1, 2]"),
        (r#"{"own": {"side": "input", "law": "u + a", "parameters": {"a": {"sice": 1}}}}"#.to_owned(), "unknown field `sice`"),
    ] {
        let error = read(&json).unwrap_err();
        assert!(error.contains(message), "{error}\n{message}");
    }
}
