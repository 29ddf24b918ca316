//! Numbers, units and laws of a model.

use fd_model::{is_plain, unit::turn};

use super::super::{
    draft::{Draft, Law, State},
    error::{Mistake, ModelError},
};

/// Whether it is as it should be.
pub(super) type Checked = Result<(), ModelError>;

pub(super) fn check(draft: &Draft) -> Checked {
    positive("sample_time", "the sample time in seconds", Some(draft.sample_time))?;
    positive("step", "the integration step in seconds", draft.step)?;
    if draft.outputs.is_empty() {
        return Err(ModelError::new("outputs", Mistake::Empty("outputs")));
    }
    for parameter in &draft.parameters {
        let key = |entry: &str| format!("parameters.{}.{entry}", parameter.name);
        unit(key("unit"), &parameter.unit)?;
        finite(key("value"), "the value", parameter.value)?;
        not_negative(key("tolerance"), "the tolerance", Some(parameter.tolerance))?;
        if let Some([low, high]) = parameter.bounds {
            let holds = low <= parameter.value && parameter.value <= high;
            if !holds {
                let expected = "between the bounds, lower bound first";
                return Err(number(key("bounds"), "the value", expected, parameter.value));
            }
        }
    }
    for input in &draft.inputs {
        unit(format!("inputs.{}.unit", input.name), &input.unit)?;
    }
    for state in &draft.states {
        check_state("states", state)?;
    }
    for output in &draft.outputs {
        let key = |entry: &str| format!("outputs.{}.{entry}", output.name);
        unit(key("unit"), &output.unit)?;
        not_negative(key("noise"), "the noise", output.noise)?;
        if output.wraps && turn(&output.unit).is_none() {
            return Err(ModelError::new(key("wraps"), Mistake::NoAngle(output.unit.clone())));
        }
    }
    for site in &draft.sites {
        unit(format!("sites.{}.unit", site.name), &site.unit)?;
        if site.enters.is_empty() {
            let key = format!("sites.{}.enters", site.name);
            return Err(ModelError::new(key, Mistake::Empty("enters")));
        }
    }
    for delay in &draft.delays {
        let nominal =
            |name: &str| draft.parameters.iter().find(|p| p.name == name).map(|p| p.value);
        // Names that are not known are told elsewhere.
        if let Ok(seconds) = delay.time.evaluate::<f64>(&nominal) {
            let key = format!("delays.{}.time", delay.name);
            finite(key, "the delay in seconds, at nominal parameters,", seconds)?;
        }
    }
    plain("name", &draft.name)?;
    plain("description", &draft.description.replace(['\n', '\r', '\t'], " "))?;
    check_controller(draft)
}

/// Names and units stand in reports and in headers of logs.
fn plain(key: &str, text: &str) -> Checked {
    if is_plain(text) {
        Ok(())
    } else {
        Err(ModelError::new(key, Mistake::NotPlain(text.to_owned())))
    }
}

fn check_controller(draft: &Draft) -> Checked {
    let Some(controller) = &draft.controller else { return Ok(()) };
    positive("controller.sample_time", "the sample time in seconds", controller.sample_time)?;
    if controller.signals.is_empty() {
        return Err(ModelError::new("controller.signals", Mistake::Empty("signals")));
    }
    for reference in &controller.references {
        unit(format!("controller.references.{}.unit", reference.name), &reference.unit)?;
    }
    for state in &controller.states {
        check_state("controller.states", state)?;
        let mistake = match (&state.law, controller.sample_time) {
            (Law::Derivative(_), Some(_)) => "a state of a sampled controller needs `update`",
            (Law::Update(_), None) => "a state of a continuous controller needs `derivative`",
            _ => continue,
        };
        let key = format!("controller.states.{}", state.name);
        return Err(ModelError::new(key, Mistake::WrongLaw(mistake)));
    }
    Ok(())
}

fn check_state(room: &str, state: &State) -> Checked {
    let key = |entry: &str| format!("{room}.{}.{entry}", state.name);
    unit(key("unit"), &state.unit)?;
    finite(key("initial"), "the initial value", state.initial)?;
    not_negative(key("tolerance"), "the tolerance", state.tolerance)
}

fn unit(key: String, unit: &str) -> Checked {
    plain(&key, unit)?;
    if unit.trim().is_empty() { Err(ModelError::new(key, Mistake::NoUnit)) } else { Ok(()) }
}

fn finite(key: String, what: &'static str, value: f64) -> Checked {
    if value.is_finite() { Ok(()) } else { Err(number(key, what, "finite", value)) }
}

fn positive(key: &str, what: &'static str, value: Option<f64>) -> Checked {
    match value {
        Some(value) if !(0.0 < value && value.is_finite()) => {
            Err(number(key.to_owned(), what, "positive and finite", value))
        }
        _ => Ok(()),
    }
}

fn not_negative(key: String, what: &'static str, value: Option<f64>) -> Checked {
    match value {
        Some(value) if !(0.0 <= value && value.is_finite()) => {
            Err(number(key, what, "finite and not negative", value))
        }
        _ => Ok(()),
    }
}

fn number(key: String, what: &'static str, expected: &'static str, found: f64) -> ModelError {
    ModelError::new(key, Mistake::Number { what, expected, found })
}
