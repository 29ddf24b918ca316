//! Linear state-space models as equations.

use fd_model::{
    Channel, SampleTime,
    file::{LinearModel, LinearSystem, ModelChannel},
};

use super::{
    DEFAULT_TOLERANCE, Definition, Draft, Input, Law, Model, ModelError, Output, Parameter, State,
    error::Mistake,
};
use crate::equation::{Expr, is_name};

/// Relative difference of two sample times that are meant to be equal.
const ROUNDING: f64 = 1e-6;

/// What a linear model file does not say.
///
/// Matrices have no parameters with a meaning, so uncertainty is put where it is felt: each output
/// gets a gain, and all states share a time scale. Both are 1, with a tolerance. A tolerance of 0
/// leaves the parameter out, and the law is that of the matrices alone.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearOptions {
    /// How well the gain from all inputs to an output is known, as a fraction. Default 0.03.
    pub gain_tolerance: f64,
    /// How well the speed of the model is known, as a fraction: time passes `1/time_scale` times as
    /// fast. In a discrete model the change from sample to sample is divided by it, which keeps
    /// equilibria. Default 0.03.
    pub time_tolerance: f64,
    /// How well the initial state is known, in the units that the matrices act on; `None`, the
    /// default, when runs start at the operating point.
    pub initial_tolerance: Option<f64>,
    /// Standard deviation of the noise of each output, in its unit; may be shorter than the
    /// outputs.
    pub noise: Vec<Option<f64>>,
}

impl Default for LinearOptions {
    fn default() -> Self {
        Self {
            gain_tolerance: DEFAULT_TOLERANCE,
            time_tolerance: DEFAULT_TOLERANCE,
            initial_tolerance: None,
            noise: Vec::new(),
        }
    }
}

impl Model {
    /// A linear model as equations, to be sampled every `ts`. Inputs and outputs are those of the
    /// file, in physical units; states are what the matrices act on, deviations from the operating
    /// point in units of the scale. Coefficients that are zero are left out.
    ///
    /// ```
    /// use fd_sim::model::{LinearOptions, Model};
    /// use fd_model::{SampleTime, file::LinearModel};
    ///
    /// let text = r#"
    /// version = 1
    /// kind = "state-space"
    /// inputs = [{ name = "fuel", unit = "kg/s", operating_point = 0.7, scale = 0.7 }]
    /// outputs = [{ name = "N", unit = "rpm", operating_point = 7000.0, scale = 7000.0 }]
    /// [matrices]
    /// A = [[-0.5, 0.0], [2.0, -4.0]]
    /// B = [[0.5], [0.0]]
    /// C = [[0.0, 3.0]]
    /// D = [[0.0]]
    /// "#;
    /// let linear = LinearModel::parse("engine.toml", text)?;
    /// let model = Model::from_linear(&linear, SampleTime::new(0.1)?, &LinearOptions::default())?;
    /// assert_eq!(model.states[1].law.expr().to_string(), "(2*x1 - 4*x2)/time_scale");
    /// assert_eq!(model.definitions[0].value.to_string(), "(fuel - 0.7)/0.7");
    /// assert_eq!(model.outputs[0].value.to_string(), "7000 + 7000*(N_gain*(3*x2))");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when a discrete model has another sample time, or a channel has a name that
    /// cannot stand in an expression or is used twice.
    pub fn from_linear(
        linear: &LinearModel,
        ts: SampleTime,
        options: &LinearOptions,
    ) -> Result<Self, ModelError> {
        let ts = match linear.system.sample_time() {
            Some(own) if differ(own, ts) => {
                let what = "the sample time in seconds";
                let expected = "that of the log, for a discrete linear model";
                let mistake = Mistake::Number { what, expected, found: own.seconds() };
                return Err(ModelError::new("sample_time", mistake));
            }
            own => own.unwrap_or(ts).seconds(),
        };
        let mut draft = Draft {
            name: linear.name.clone().unwrap_or_else(|| "linear".to_owned()),
            sample_time: ts,
            ..Draft::default()
        };
        // All names that logs know come first; those of states and parameters keep clear of them.
        for ModelChannel { channel, .. } in &linear.inputs {
            let (name, unit) = (channel.name.clone(), unit(channel));
            draft.inputs.push(Input { name, unit, saturation: None });
        }
        for (i, ModelChannel { channel, .. }) in linear.outputs.iter().enumerate() {
            let noise = options.noise.get(i).copied().flatten();
            let output = Output::new(&channel.name, unit(channel), Expr::Number(0.0));
            draft.outputs.push(Output { noise, ..output });
        }
        add_states(&mut draft, linear, options);
        let inputs = deviations(&mut draft, &linear.inputs);
        let states: Vec<Expr> = draft.states.iter().map(|s| Expr::name(&s.name)).collect();
        let signals: Vec<Expr> = states.into_iter().chain(inputs).collect();

        let [a, b, c, d] = linear.system.matrices();
        let nx = a.nrows();
        let row = |i: usize, left: faer::MatRef<'_, f64>, right: faer::MatRef<'_, f64>| {
            let right = (0..right.ncols()).map(move |j| right[(i, j)]);
            (0..nx).map(move |j| left[(i, j)]).chain(right).collect::<Vec<f64>>()
        };
        let time = uncertain(&mut draft, "time_scale", options.time_tolerance);
        for i in 0..nx {
            let mut row = row(i, a, b);
            let state = signals[i].clone();
            draft.states[i].law = match (&linear.system, &time) {
                (LinearSystem::Continuous(_), None) => Law::Derivative(sum(&row, &signals)),
                (LinearSystem::Continuous(_), Some(time)) => {
                    Law::Derivative(sum(&row, &signals) / time.clone())
                }
                (LinearSystem::Discrete(_), None) => Law::Update(sum(&row, &signals)),
                (LinearSystem::Discrete(_), Some(time)) => {
                    row[i] -= 1.0;
                    Law::Update(state + sum(&row, &signals) / time.clone())
                }
            };
        }
        for (i, ModelChannel { channel, scale }) in linear.outputs.iter().enumerate() {
            let wish = format!("{}_gain", channel.name);
            let mut value = sum(&row(i, c, d), &signals);
            if let Some(gain) = uncertain(&mut draft, &wish, options.gain_tolerance) {
                value = gain * value;
            }
            if let Some(scale) = scale.scale {
                value = Expr::Number(scale) * value;
            }
            if scale.offset != 0.0 {
                value = Expr::Number(scale.offset) + value;
            }
            draft.outputs[i].value = value;
        }
        Self::try_from(draft)
    }
}

fn differ(own: SampleTime, other: SampleTime) -> bool {
    ROUNDING * own.seconds() < (own.seconds() - other.seconds()).abs()
}

fn unit(channel: &Channel) -> String {
    let unit = channel.unit.trim();
    if unit.is_empty() { "1".to_owned() } else { unit.to_owned() }
}

/// Adds the states, under their names where these can stand in expressions and are free.
fn add_states(draft: &mut Draft, linear: &LinearModel, options: &LinearOptions) {
    let [a, ..] = linear.system.matrices();
    for i in 0..a.nrows() {
        let known = linear.states.get(i);
        let name = known.map(|state| state.channel.name.clone()).filter(|name| is_name(name));
        let name = draft.fresh_name(&name.unwrap_or_else(|| format!("x{}", i + 1)));
        let unit = match known {
            Some(state) if state.scale.scale.is_none() => unit(&state.channel),
            _ => "1".to_owned(),
        };
        let (tolerance, law) = (options.initial_tolerance, Law::Derivative(Expr::Number(0.0)));
        draft.states.push(State { name, unit, initial: 0.0, tolerance, law });
    }
}

/// The inputs as the matrices see them: by name where there is no operating point and no scale, by
/// a definition elsewhere.
fn deviations(draft: &mut Draft, inputs: &[ModelChannel]) -> Vec<Expr> {
    let each = inputs.iter().map(|ModelChannel { channel, scale }| {
        let mut value = Expr::name(&channel.name);
        if scale.offset == 0.0 && scale.scale.is_none() {
            return value;
        }
        if scale.offset != 0.0 {
            value = value - Expr::Number(scale.offset);
        }
        if let Some(scale) = scale.scale {
            value = value / Expr::Number(scale);
        }
        let name = draft.fresh_name(&format!("{}_deviation", channel.name));
        draft.definitions.push(Definition { name: name.clone(), value });
        Expr::Name(name)
    });
    each.collect()
}

/// Adds a factor that is 1, unless it is exact.
fn uncertain(draft: &mut Draft, wish: &str, tolerance: f64) -> Option<Expr> {
    (tolerance != 0.0).then(|| {
        let name = draft.fresh_name(wish);
        let parameter = Parameter { tolerance, ..Parameter::new(&name, "1", 1.0) };
        draft.parameters.push(parameter);
        Expr::Name(name)
    })
}

/// The sum of products of which the coefficient is not zero.
fn sum(coefficients: &[f64], signals: &[Expr]) -> Expr {
    let terms = coefficients.iter().zip(signals).filter(|(c, _)| **c != 0.0);
    // Simplified, a factor of 1 is left out.
    let product = |c: f64, signal: &Expr| (Expr::Number(c) * signal.clone()).simplify();
    let add = |sum: Option<Expr>, (&c, signal): (&f64, &Expr)| {
        Some(match sum {
            None => product(c, signal),
            Some(sum) if c < 0.0 => sum - product(-c, signal),
            Some(sum) => sum + product(c, signal),
        })
    };
    terms.fold(None, add).unwrap_or(Expr::Number(0.0))
}
