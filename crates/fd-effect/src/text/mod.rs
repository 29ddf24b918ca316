//! User-defined effects, as text in the expression language of model files.
//!
//! | module | what it is for |
//! |---|---|
//! | [`TextEffects`] | effects as a file or a program states them, by label |
//! | [`TextEffect`] | one of them: an [`Effect`](crate::Effect) like those of the library |
//!
//! A law is an expression in which `u` is what arrives at an input, `v` and `x` velocity and position where a
//! force acts, `y` what a sensor measures, `p` a parameter; `t`, `dt`, `first` and `pi` mean what they mean in
//! models, and so do all names of the model. The value of the expression replaces `u`, `y` or `p`; a force is
//! added.
//!
//! *When not to use:* for memory that must be exact over a step, for delays, and for starts that depend on the
//! log: implement [`Effect`](crate::Effect).

mod check;
mod effect;
mod error;
mod parameter;
mod read;

pub use self::{
    error::TextError,
    parameter::{TextParameter, TextState},
    read::TextEffects,
};
use fd_sim::equation::Expr;

/// Where an effect of one's own is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum On {
    Input,
    Force,
    Output,
    Parameter,
}

impl On {
    /// As it is written.
    const ALL: [(&'static str, Self); 4] = [
        ("input", Self::Input),
        ("force", Self::Force),
        ("output", Self::Output),
        ("parameter", Self::Parameter),
    ];

    /// What may be named there.
    fn locals(self) -> &'static [&'static str] {
        match self {
            Self::Input => &["u"],
            Self::Force => &["v", "x"],
            Self::Output => &["y"],
            Self::Parameter => &["p"],
        }
    }

    /// What the law says where it is absent.
    fn absent(self) -> &'static str {
        match self {
            Self::Input => "u",
            Self::Force => "0",
            Self::Output => "y",
            Self::Parameter => "p",
        }
    }
}

/// An effect of one's own: a law with parameters, at some places or at all of a kind.
///
/// ```
/// use fd_effect::{Effect, text::TextEffects};
/// use fd_sim::{model::Model, scales::ReplayScales};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "tank"
/// sample_time = 60.0
/// inputs = { flow = { unit = "m^3/s" } }
/// states = { h = { unit = "m", initial = 1.0, derivative = "flow - 1e-4*h" } }
/// outputs = { level = { unit = "m", value = "h" } }
/// "#.parse()?;
/// let u: Vec<f64> = (0..500).map(|k| if k % 100 < 50 { 1e-4 } else { 2e-4 }).collect();
/// let scales = ReplayScales::of(&model, model.sample_time()?, &u, 500)?;
///
/// // A pump that loses a part of its flow with the temperature of the day.
/// let effects: TextEffects = serde_json::from_str(r#"{"daily-swing": {
///     "side": "input",
///     "law": "u*(1 + a*sin(2*pi*t/86400))",
///     "parameters": {"a": {"size": 0.1, "bounds": [0, 0.5]}}
/// }}"#)?;
/// let effects = effects.effects()?;
/// effects[0].check(&model)?;
/// let candidates = effects[0].candidates(&model, &scales);
/// let candidate = candidates[0].as_ref().map_err(ToString::to_string)?;
/// assert_eq!(candidate.parameters[0].name, "flow_a");
/// let applied = candidate.model.definitions.last().ok_or("a definition")?;
/// assert_eq!(applied.value.to_string(), "flow*(1 + flow_a*sin(2*pi*t/86400))");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TextEffect {
    label: &'static str,
    family: &'static str,
    on: On,
    /// Places; none for all.
    at: Vec<String>,
    law: Expr,
    parameters: Vec<(String, TextParameter)>,
    states: Vec<(String, TextState, Expr)>,
}
