//! The other side: any simulator of this library, served to whoever speaks the protocol.

use std::io::{BufRead, Error, ErrorKind, Read, Result, Write};

use super::{
    super::contract::{Entry, Powers, Stated},
    PROTOCOL_VERSION,
    frame::{self, HEAD, Op, begin, put},
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
    #[derive(serde::Serialize)]
    struct Ours<'a> {
        version: u32,
        #[serde(flatten)]
        stated: &'a Stated,
    }
    let mut line = String::new();
    input.read_line(&mut line)?;
    let ours = Ours { version: PROTOCOL_VERSION, stated: hello };
    writeln!(output, "{}", serde_json::to_string(&ours).map_err(Error::other)?)?;
    output.flush()?;

    let (np, nx) = (simulator.parameters().len(), simulator.initial().len());
    let (nu, nf, ny) =
        (simulator.inputs().len(), simulator.ports().len(), simulator.outputs().len());
    let (mut y, mut bytes) = (Vec::new(), Vec::new());
    while let Some((op, values)) = ask(&mut input)? {
        let wrong = |expected: usize| {
            let found = values.len();
            Error::new(ErrorKind::InvalidData, format!("op {op}: {found} values, not {expected}"))
        };
        let (op, samples) = match op {
            1 if values.len() == 1 + np + nx => (Op::Reset, 0),
            2 if values.len() == nu + nf => (Op::Step, 1),
            3 if 2 + np + nx <= values.len() => {
                let samples = natural(values[1])?;
                let expected = 2 + np + nx + samples * (nu + nf);
                if values.len() != expected {
                    return Err(wrong(expected));
                }
                (Op::Rollout, samples)
            }
            4 if values.len() == nu => (Op::Measure, 1),
            5 => return Ok(()),
            1 => return Err(wrong(1 + np + nx)),
            2 => return Err(wrong(nu + nf)),
            3 => return Err(wrong(2 + np + nx)),
            4 => return Err(wrong(nu)),
            _ => return Err(wrong(0)),
        };
        y.clear();
        y.resize(samples * ny, f64::NAN);
        let begin_run = |simulator: &mut dyn Simulator, rest: &[f64]| -> Result<()> {
            simulator.start(&rest[..np], &rest[np..np + nx], natural(values[0])? as u64);
            Ok(())
        };
        match op {
            Op::Reset => begin_run(simulator, &values[1..])?,
            Op::Step => {
                let (u, f) = values.split_at(nu);
                simulator.step(u, u, f, &mut y);
            }
            Op::Measure => {
                simulator.measure(&values, &mut y);
            }
            _ => {
                begin_run(simulator, &values[2..])?;
                for k in 0..samples {
                    let row = &values[2 + np + nx + k * (nu + nf)..][..nu + nf];
                    let (u, f) = row.split_at(nu);
                    simulator.step(u, u, f, &mut y[k * ny..(k + 1) * ny]);
                }
            }
        }
        let x = if matches!(op, Op::Step | Op::Rollout) { simulator.state() } else { &[] };
        let count = u32::try_from(y.len() + x.len()).map_err(Error::other)?;
        begin(&mut bytes, op, count);
        put(&mut bytes, &y);
        put(&mut bytes, x);
        output.write_all(&bytes)?;
        output.flush()?;
    }
    Ok(())
}

/// The next frame; `None` at the end.
fn ask(input: &mut impl Read) -> Result<Option<(u32, Vec<f64>)>> {
    let mut head = [0; HEAD];
    match input.read_exact(&mut head) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
        read => read?,
    }
    let [op, _, count] = frame::head(&head);
    let mut bytes = Vec::new();
    // As much as comes, not as much as is claimed.
    input.take(8 * u64::from(count)).read_to_end(&mut bytes)?;
    if bytes.len() < 8 * count as usize {
        return Ok(None);
    }
    let mut values = vec![0.0; count as usize];
    frame::get(&bytes, &mut values);
    Ok(Some((op, values)))
}

/// A number that counts something.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked")]
fn natural(value: f64) -> Result<usize> {
    // Counts up to 2^32 are exact.
    if (0.0..=f64::from(u32::MAX)).contains(&value) && value.fract() == 0.0 {
        return Ok(value as usize);
    }
    Err(Error::new(ErrorKind::InvalidData, format!("{value} is no count of samples")))
}
