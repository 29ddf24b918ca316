//! Controllers that the model does not have: they see the measured output, noise and all.

use fd_sim::{
    equation::Expr,
    model::{self, Draft, Law as StateLaw, LoadError, Model, Output, Reference, Signal, State},
};
use serde::{Deserialize, Serialize};

use super::{error::BlindError, random::Random};

/// How a controller acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// In proportion to the error.
    Proportional,
    /// In proportion, to the integral, and to the rate of the output.
    Pid,
    /// To the error, the rate of the output, and another output.
    StateFeedback,
    /// One of two commands, with a hysteresis.
    BangBang,
    /// Now and then, by a look at what was some time ago, with an unsteady hand.
    Human,
}

/// A controller with its settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// How it acts.
    pub action: Action,
    /// Place of the input that it drives.
    pub input: usize,
    /// Place of the output that is to follow the reference.
    pub output: usize,
    /// Command at no error.
    pub trim: f64,
    /// Command per error.
    pub gain: f64,
    /// Rate of the command per error.
    pub integral: f64,
    /// Command per rate of the output, against it.
    pub rate: f64,
    /// Another output: its place, command against its deviation, where it usually is.
    pub inner: Option<(usize, f64, f64)>,
    /// Error, or command, that does not matter.
    pub band: f64,
    /// Largest change of the command from the trim.
    pub limit: f64,
    /// Share of the filtered rate that stays from sample to sample.
    pub pole: f64,
    /// Samples between two looks, and from what is seen to what is done.
    pub looks: [usize; 2],
    /// Output at rest.
    pub rest: f64,
    /// Middle and size of the reference.
    pub reference: [f64; 2],
    /// Seed of what is random.
    pub seed: u64,
}

/// A controller at work.
pub(super) struct Feedback<'a> {
    settings: &'a Controller,
    ts: f64,
    before: f64,
    rate: f64,
    integral: f64,
    side: f64,
    seen: Vec<f64>,
    hand: Random,
}

/// How far a hand is from what it wants, as a share of that.
const UNSTEADY: f64 = 0.3;

impl Controller {
    pub(super) fn start(&self, ts: f64, run: u64) -> Feedback<'_> {
        Feedback {
            settings: self,
            ts,
            before: self.rest,
            rate: 0.0,
            integral: 0.0,
            side: 1.0,
            seen: Vec::new(),
            hand: Random::named(self.seed, &format!("hand/{run}")),
        }
    }

    /// The model with this controller in it; `None` for a human, of whom nobody has a model.
    ///
    /// The reference is called as [`reference_name`] says, the logged command is one more output.
    pub(super) fn in_model(&self, model: &Model) -> Result<Option<Model>, BlindError> {
        if self.action == Action::Human {
            return Ok(None);
        }
        let mut draft = model.clone().into_draft();
        let (input, y) = (draft.inputs[self.input].clone(), draft.outputs[self.output].clone());
        let (reference, ts) = (reference_name(model, self), draft.sample_time);
        let name = |wish: &str| draft.fresh_name(wish);
        let [before, rate, integral, side] = ["y_before", "y_rate", "integral", "side"].map(name);
        let (rate_now, side_now) = (name("rate_now"), name("side_now"));
        let command = command_name(&draft, &input.name);
        let (yn, pole) = (&y.name, self.pole);
        let error = format!("({reference} - {yn})");
        let filtered = format!("{pole:?}*{rate} + {:?}*({yn} - {before})/{ts:?}", 1.0 - pole);
        let sum = if self.action == Action::BangBang {
            format!("{:?} + {:?}*{side_now}", self.trim, self.limit)
        } else {
            let inner = self.inner.map_or_else(String::new, |(place, k, mean)| {
                format!(" - {k:?}*({} - {mean:?})", draft.outputs[place].name)
            });
            format!(
                "{:?} + clamp({:?}*{error} + {integral} - {:?}*{rate_now}{inner}, {:?}, {:?})",
                self.trim, self.gain, self.rate, -self.limit, self.limit
            )
        };
        let k = self.gain.abs().max(f64::MIN_POSITIVE);
        let way = format!("({:?}*{error} - {:?}*{rate_now})/{k:?}", self.gain, self.rate);
        let b = self.band;
        let switched = format!("clamp(sign({way} - {b:?}) + sign({way} + {b:?}) + {side}, -1, 1)");
        let limit = self.limit;
        let summed = format!(
            "clamp({integral} + {:?}*{error}, {:?}, {limit:?})",
            ts * self.integral,
            -limit
        );
        let state = |name: &str, initial: f64, update: &str| -> Result<State, BlindError> {
            Ok(State {
                name: name.to_owned(),
                unit: "1".to_owned(),
                initial,
                tolerance: None,
                law: StateLaw::Update(parse(update)?),
            })
        };
        let definition = |name: &str, value: &str| -> Result<model::Definition, BlindError> {
            Ok(model::Definition { name: name.to_owned(), value: parse(value)? })
        };
        draft.controller = Some(model::Controller {
            sample_time: Some(ts),
            references: vec![Reference { name: reference.clone(), unit: y.unit.clone() }],
            states: vec![
                state(&before, self.rest, yn)?,
                state(&rate, 0.0, &rate_now)?,
                state(&integral, 0.0, &summed)?,
                state(&side, 1.0, &side_now)?,
            ],
            definitions: vec![definition(&rate_now, &filtered)?, definition(&side_now, &switched)?],
            signals: vec![Signal { input: input.name.clone(), value: parse(&sum)? }],
        });
        // The log has the command as it is; the fit needs some noise of it.
        let size = 1e-4 * self.limit;
        let shown = Output::new(command, &input.unit, Expr::name(&input.name));
        draft.outputs.push(Output { noise: Some(size), ..shown });
        let model = Model::try_from(draft).map_err(|error| BlindError::Model {
            error: Box::new(LoadError::Model { file: "the model with its loop".to_owned(), error }),
        })?;
        Ok(Some(model))
    }
}

/// Name of the reference in logs and in the model with the controller.
pub(super) fn reference_name(model: &Model, controller: &Controller) -> String {
    format!("{}_ref", model.outputs[controller.output].name)
}

/// Name of the output that shows the command, in the model with the controller.
pub(super) fn command_name(draft: &Draft, input: &str) -> String {
    draft.fresh_name(&format!("{input}_command"))
}

fn parse(text: &str) -> Result<Expr, BlindError> {
    Expr::parse(text).map_err(|error| BlindError::content("a controller".as_ref(), error))
}

impl Feedback<'_> {
    /// The command, from the measured outputs and the reference; the memory moves on.
    pub(super) fn act(&mut self, y: &[f64], reference: f64) -> f64 {
        let s = self.settings;
        let error = reference - y[s.output];
        self.rate = s.pole * self.rate + (1.0 - s.pole) * (y[s.output] - self.before) / self.ts;
        self.before = y[s.output];
        match s.action {
            Action::BangBang => {
                let way = (s.gain * error - s.rate * self.rate) / s.gain.abs();
                if way.abs() > s.band {
                    self.side = way.signum();
                }
                s.trim + s.limit * self.side
            }
            Action::Human => {
                let k = self.seen.len();
                self.seen.push(error);
                let [every, late] = s.looks;
                if k.is_multiple_of(every) {
                    let past = self.seen[k.saturating_sub(late)];
                    let hand = 1.0 + UNSTEADY * self.hand.uniform(-1.0, 1.0);
                    let wanted = if past.abs() < s.band { 0.0 } else { s.gain * hand * past };
                    // What is left of the last correction, and a new one.
                    self.integral = (self.integral + wanted).clamp(-s.limit, s.limit);
                }
                s.trim + self.integral
            }
            _ => {
                let inner = s.inner.map_or(0.0, |(place, k, mean)| k * (y[place] - mean));
                let sum = s.gain * error + self.integral - s.rate * self.rate - inner;
                let next = self.integral + self.ts * s.integral * error;
                self.integral = next.clamp(-s.limit, s.limit);
                s.trim + sum.clamp(-s.limit, s.limit)
            }
        }
    }
}
