//! The other side: any simulator of this library, served to whoever speaks the protocol.

use std::io::{BufRead, Error, ErrorKind, Read, Result, Write};

use super::{
    super::{
        error::OutsideError,
        powers::Powers,
        source::{Instance, Lost, Start},
        stated::{Entry, Stated},
    },
    frame::{self, HEAD, Op, PROTOCOL_VERSION, begin, put},
};
use crate::simulate::Simulator;

/// What a simulator of this library says of itself; `noise` are standard deviations of its outputs, as far as
/// they are known.
#[must_use]
pub fn stated(name: &str, simulator: &dyn Simulator, noise: &[Option<f64>]) -> Stated {
    let channel = |channel: &fd_model::Channel| Entry {
        name: channel.name.clone(),
        unit: Some(channel.unit.clone()),
        ..Entry::default()
    };
    let mut can_measure = simulator.boxed();
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    can_measure.start(&theta, &x0, 0);
    let (u, mut y) = (vec![0.0; simulator.inputs().len()], vec![0.0; simulator.outputs().len()]);
    let measure = can_measure.measure(&u, &mut y);
    let outputs = simulator.outputs().iter().enumerate();
    let lent = simulator.parameters().len().saturating_sub(simulator.natives().len());
    Stated {
        name: Some(name.to_owned()),
        sample_time: Some(simulator.ts().seconds()),
        inputs: simulator.inputs().iter().map(channel).collect(),
        outputs: outputs
            .map(|(i, c)| Entry { noise: noise.get(i).copied().flatten(), ..channel(c) })
            .collect(),
        parameters: (simulator.parameters()[..lent].iter())
            .map(|p| Entry {
                name: p.name.clone(),
                unit: Some(p.unit.clone()),
                value: Some(p.value),
                tolerance: Some(p.tolerance),
                bounds: p.bounds,
                ..Entry::default()
            })
            .collect(),
        states: (simulator.initial().iter())
            .map(|x| Entry {
                initial: Some(x.value),
                tolerance: x.tolerance,
                ..channel(&x.channel)
            })
            .collect(),
        ports: simulator.ports().iter().map(|port| channel(&port.channel)).collect(),
        native_effects: simulator.natives().iter().map(Entry::of_native).collect(),
        powers: Some(Powers {
            rollout: true,
            measure,
            states: true,
            precision: Some(f64::EPSILON),
            ..Powers::default()
        }),
    }
}

/// Serves a simulator until the other side says goodbye or is gone: the hello, then frames.
///
/// ```
/// use fd_model::SampleTime;
/// use fd_sim::{model::Model, outside::{serve, stated}, simulate::EquationSimulator};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "sum"
/// sample_time = 1.0
/// inputs = { u = { unit = "1" } }
/// states = { x = { unit = "1", initial = 0.0, update = "x + u" } }
/// outputs = { y = { unit = "1", value = "x" } }
/// "#.parse()?;
/// let mut simulator = EquationSimulator::new(&model)?;
/// let hello = stated("sum", &simulator, &[]);
///
/// // A run of two samples: op 3, one lane, five values: first, samples, the initial state, two inputs.
/// let mut asked = b"{}\n".to_vec();
/// [3u32, 1, 5].iter().for_each(|word| asked.extend(word.to_le_bytes()));
/// [0.0, 2.0, 7.0, 1.0, 1.0].iter().for_each(|value: &f64| asked.extend(value.to_le_bytes()));
/// let mut answer = Vec::new();
/// serve(&mut simulator, &hello, &asked[..], &mut answer)?;
///
/// // Two outputs, and the state at the end.
/// let values: Vec<f64> = answer[answer.len() - 24..]
///     .chunks(8)
///     .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()))
///     .collect();
/// assert_eq!(values, [7.0, 8.0, 9.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when reading or writing fails, or what comes is not what the protocol says.
pub fn serve(
    simulator: &mut dyn Simulator,
    hello: &Stated,
    mut input: impl BufRead,
    mut output: impl Write,
) -> Result<()> {
    input.read_line(&mut String::new())?;
    greet(hello, &mut output)?;
    // What was not said of states is that they are there.
    let shows_states = hello.powers.is_none_or(|powers| powers.states);
    let widths = Widths::of(simulator, shows_states);
    let lane = || -> std::result::Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(Served(simulator.boxed())))
    };
    answer(widths, vec![lane().map_err(Error::other)?], &lane, input, output)
}

/// Takes the hello of the other side: what it has been told of the simulator.
#[cfg(feature = "fmu")]
pub(in super::super) fn heard(input: &mut impl BufRead) -> Result<Stated> {
    #[derive(serde::Deserialize)]
    struct Theirs {
        #[serde(default)]
        stated: Stated,
    }
    let mut line = String::new();
    input.read_line(&mut line)?;
    let theirs: Theirs = serde_json::from_str(&line).map_err(|error| {
        let message =
            format!("the hello of who asks: expected a line of JSON, found `{line}` ({error})");
        Error::new(ErrorKind::InvalidData, message)
    })?;
    Ok(theirs.stated)
}

/// Says hello.
pub(in super::super) fn greet(hello: &Stated, output: &mut impl Write) -> Result<()> {
    #[derive(serde::Serialize)]
    struct Ours<'a> {
        version: u32,
        #[serde(flatten)]
        stated: &'a Stated,
    }
    let ours = Ours { version: PROTOCOL_VERSION, stated: hello };
    writeln!(output, "{}", serde_json::to_string(&ours).map_err(Error::other)?)?;
    output.flush()
}

/// Answers frames by simulators beside each other, one for each lane that is asked for; `more` starts another.
pub(in super::super) fn answer<'a>(
    widths: Widths,
    mut lanes: Vec<Box<dyn Instance + 'a>>,
    more: &dyn Fn() -> std::result::Result<Box<dyn Instance + 'a>, OutsideError>,
    mut input: impl BufRead,
    mut output: impl Write,
) -> Result<()> {
    let (mut values, mut bytes) = (Vec::new(), Vec::new());
    while let Some((op, wanted, asked)) = ask(&mut input)? {
        if op == Op::Bye as u32 {
            break;
        }
        let (op, samples) = widths.check(op, wanted, &asked)?;
        if matches!(op, Op::Reset | Op::Rollout) {
            // A lane brings values here, so that there are no more of them than values came.
            while lanes.len() < wanted {
                lanes.push(more().map_err(Error::other)?);
            }
        } else if lanes.len() < wanted {
            let message =
                format!("{} of {wanted} lanes, of which {} have begun", op.name(), lanes.len());
            return Err(Error::new(ErrorKind::InvalidData, message));
        }
        values.clear();
        let each = asked.len() / wanted;
        let acted = lanes[..wanted].iter_mut().enumerate().try_for_each(|(i, lane)| {
            widths.act(&mut **lane, op, samples, &asked[i * each..(i + 1) * each], &mut values)
        });
        let wanted = u32::try_from(wanted).map_err(Error::other)?;
        match acted {
            Ok(()) => {
                let count = u32::try_from(values.len()).map_err(Error::other)?;
                begin(&mut bytes, op, [wanted, count]);
                put(&mut bytes, &values);
            }
            Err(Lost::Refused) => {
                bytes.clear();
                bytes.resize(HEAD, 0);
            }
            Err(Lost::Gone(error) | Lost::Broken(error)) => return Err(Error::other(*error)),
        }
        output.write_all(&bytes)?;
        output.flush()?;
    }
    Ok(())
}

/// A simulator of this library as one that is asked.
#[derive(Debug)]
struct Served(Box<dyn Simulator>);

impl Instance for Served {
    fn reset(&mut self, start: Start<'_>) -> std::result::Result<(), Lost> {
        self.0.start(start.theta, start.x0, start.first);
        Ok(())
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> std::result::Result<(), Lost> {
        self.0.measure(u, y);
        Ok(())
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> std::result::Result<(), Lost> {
        let (u, f) = row.split_at(self.0.inputs().len());
        self.0.step(u, u, f, y);
        if !x.is_empty() {
            x.copy_from_slice(self.0.state());
        }
        Ok(())
    }
}

/// How many values belong to what.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Widths {
    parameters: usize,
    states: usize,
    inputs: usize,
    ports: usize,
    outputs: usize,
    /// Whether states are answered.
    shows_states: bool,
}

impl Widths {
    fn of(simulator: &dyn Simulator, shows_states: bool) -> Self {
        Self {
            shows_states,
            parameters: simulator.parameters().len(),
            states: simulator.initial().len(),
            inputs: simulator.inputs().len(),
            ports: simulator.ports().len(),
            outputs: simulator.outputs().len(),
        }
    }

    /// Those of a contract.
    #[cfg(feature = "fmu")]
    pub(in super::super) fn of_contract(contract: &super::super::Contract) -> Self {
        Self {
            shows_states: contract.powers.states,
            parameters: contract.parameters.len(),
            states: contract.initial.len(),
            inputs: contract.inputs.len(),
            ports: contract.ports.len(),
            outputs: contract.outputs.len(),
        }
    }

    /// What is asked for, and samples of it; or why so many values cannot be for it.
    fn check(&self, op: u32, lanes: usize, values: &[f64]) -> Result<(Op, usize)> {
        let row = self.inputs + self.ports;
        let start = self.parameters + self.states;
        let samples = if op == Op::Rollout as u32 { natural(values.get(1).copied())? } else { 1 };
        let (found, expected) = match op {
            1 => (Op::Reset, 1 + start),
            2 => (Op::Step, row),
            3 => (Op::Rollout, samples.saturating_mul(row).saturating_add(2 + start)),
            4 => (Op::Measure, self.inputs),
            _ => {
                let message = format!("op {op}, not 1 to 5");
                return Err(Error::new(ErrorKind::InvalidData, message));
            }
        };
        if lanes == 0 || Some(values.len()) != expected.checked_mul(lanes) {
            let message =
                format!("op {op}, {lanes} lanes: {} values, not {expected} each", values.len());
            return Err(Error::new(ErrorKind::InvalidData, message));
        }
        if matches!(found, Op::Reset | Op::Rollout) {
            values
                .chunks_exact(expected)
                .try_for_each(|lane| natural(Some(lane[0])).map(|_| ()))?;
        }
        Ok((found, samples))
    }

    /// Does what is asked of a lane, and adds what it answers: outputs, and then states.
    fn act(
        &self,
        lane: &mut dyn Instance,
        op: Op,
        samples: usize,
        values: &[f64],
        answer: &mut Vec<f64>,
    ) -> std::result::Result<(), Lost> {
        let (from, samples) = (answer.len(), if op == Op::Reset { 0 } else { samples });
        let is_move = matches!(op, Op::Step | Op::Rollout);
        let shown = if self.shows_states && is_move { self.states } else { 0 };
        answer.resize(from + samples * self.outputs + shown, f64::NAN);
        let (y, x) = answer[from..].split_at_mut(samples * self.outputs);
        match op {
            Op::Reset => lane.reset(self.start(values.first().copied(), &values[1..])),
            Op::Step => lane.step(values, y, x),
            Op::Measure => lane.measure(values, y),
            Op::Rollout | Op::Bye => {
                let (start, rows) = values[2..].split_at(self.parameters + self.states);
                let start = self.start(values.first().copied(), start);
                // Those of a run without samples.
                x.iter_mut().zip(start.x0).for_each(|(x, x0)| *x = *x0);
                lane.rollout(start, rows, samples, y, x)
            }
        }
    }

    /// Where a run begins.
    fn start<'v>(&self, first: Option<f64>, values: &'v [f64]) -> Start<'v> {
        let (theta, x0) = values.split_at(self.parameters);
        // It was checked.
        let first = natural(first).unwrap_or(0) as u64;
        Start { theta, x0, first }
    }
}

/// The next frame; `None` at the end.
fn ask(input: &mut impl Read) -> Result<Option<(u32, usize, Vec<f64>)>> {
    let mut head = [0; HEAD];
    match input.read_exact(&mut head) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
        read => read?,
    }
    let [op, lanes, count] = frame::head(&head);
    let mut bytes = Vec::new();
    // As much as comes, not as much as is claimed.
    input.take(8 * u64::from(count)).read_to_end(&mut bytes)?;
    if bytes.len() < 8 * count as usize {
        return Ok(None);
    }
    let mut values = vec![0.0; count as usize];
    frame::get(&bytes, &mut values);
    Ok(Some((op, lanes as usize, values)))
}

/// A number that counts something.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked")]
fn natural(value: Option<f64>) -> Result<usize> {
    let value = value.unwrap_or(f64::NAN);
    // Counts up to 2^32 are exact.
    if (0.0..=f64::from(u32::MAX)).contains(&value) && value.fract() == 0.0 {
        return Ok(value as usize);
    }
    Err(Error::new(ErrorKind::InvalidData, format!("{value} is no count of samples")))
}
