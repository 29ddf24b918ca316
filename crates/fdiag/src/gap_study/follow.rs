//! Plants that run away from any start are followed along their logs.

use std::borrow::Cow;

use fd_effect::Candidate;
use fd_gap::{
    diagnose::{Case, commanded, saw_the_log},
    fit::{FitError, Horizon, Log},
    quality::{grid_step, robust_third_difference_floor},
};
use fd_model::Record;
use fd_sim::{
    model::Model,
    simulate::{Follower, LoggedLoop, Nominal, OperatingPoint, linearize},
};

use super::memory::Memory;

/// Smallest noise of a signal without any, in its root mean square.
const EXACT: f64 = 1e-6;
/// Growth of a distance along the log of what falls over.
const FALLS_OVER: f64 = 100.0;

/// The simulator of a model that runs away from its start, corrected by what was logged; `None` for one that does
/// not, or that cannot be held so (one with a delay, states with update laws, or a controller that acts between samples).
/// A controller of the model sees what was logged, if that explains the log better than a closed loop that knows
/// nothing of it. Noise that the model does not state is that of third differences.
///
/// ```
/// use fd_model::{Channel, Record};
/// use fd_sim::model::Model;
/// use fdiag::gap_study::follow;
///
/// let tank: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "tank"
/// sample_time = 1.0
/// inputs = { u = { unit = "m/s" } }
/// outputs = { y = { unit = "m", value = "h" } }
/// states = { h = { unit = "m", initial = 0.0, derivative = "u - 0.1*h" } }
/// "#.parse()?;
/// let (u, y) = ([Channel::new("u", "m/s")], [Channel::new("y", "m")]);
/// let log = Record::from_rows(u.to_vec(), y.to_vec(), [([1.0], [0.2]); 90], tank.sample_time()?)?;
/// assert!(follow(&tank, &[log])?.is_none(), "a tank forgets");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or the logs do not fit it.
pub fn follow<'a>(
    nominal: &'a dyn Nominal,
    records: &[Record],
) -> Result<Option<Follower<'a>>, FitError> {
    let longest = records.iter().max_by_key(|record| record.len()).ok_or(FitError::NoLog)?;
    let looped = LoggedLoop::of(nominal, longest.ts());
    let Some(inputs) = runaway_inputs(nominal, looped.as_ref(), longest)? else { return Ok(None) };
    let noise = nominal.model().outputs.iter().map(|output| {
        let column = longest.output_index(&output.name);
        let signal: Vec<f64> = column.map_or_else(Vec::new, |c| longest.output(c).collect());
        noise(&signal, output.noise)
    });
    let follower = Follower::along(nominal, longest, &noise.collect::<Vec<_>>(), &inputs);
    let Some(looped) = looped else { return Ok(follower) };
    let commanded = commanded(&looped, records);
    let follower = follower.map(|follower| follower.with_commanded(&commanded));
    Ok(follower.filter(|follower| is_better(follower, nominal, records)))
}

/// Mean and size of each input of a plant that runs away from its start along a log; `None` for one that does not.
/// Whoever holds the plant sees the log: a controller of the model does, where it is `looped`, and its commands drive the plant.
fn runaway_inputs(
    nominal: &dyn Nominal,
    looped: Option<&LoggedLoop<'_>>,
    record: &Record,
) -> Result<Option<Vec<[f64; 2]>>, FitError> {
    let ts = record.ts();
    let (simulator, seen) = match looped {
        Some(looped) => (looped.simulator(ts)?, looped.record(record).ok().map(Cow::Owned)),
        None => (nominal.simulator(ts)?, Some(Cow::Borrowed(record))),
    };
    let Some(seen) = seen else { return Ok(None) };
    let log = Log::new(&seen, &*simulator, 1)?;
    let u: Vec<f64> = (0..log.samples()).flat_map(|k| log.input(k).to_vec()).collect();
    let (plant, commands) = match looped {
        Some(looped) => {
            let plant = nominal.model().without_controller().ok();
            let commands = looped.commands(&u, ts).map(|commands| Cow::Owned(commands.inputs));
            let Some((plant, commands)) = plant.zip(commands) else { return Ok(None) };
            (Cow::Owned(plant), commands)
        }
        None => (Cow::Borrowed(nominal.model()), Cow::Borrowed(&u)),
    };
    let width = plant.external_inputs().len();
    let of = |i| fd_numeric::mean_and_deviation(commands.iter().skip(i).step_by(width).copied());
    let inputs: Vec<[f64; 2]> = (0..width).map(of).collect();
    let seconds = log.samples() as f64 * ts.seconds();
    let runs_away = falls_over(&plant, &inputs, seconds)
        || Memory::of(&*simulator, &u, log.samples()).runs_away;
    Ok(runs_away.then_some(inputs))
}

/// Whether a controller that saw what was logged explains the logs better than one that saw what a model shows.
fn is_better(follower: &Follower<'_>, closed: &dyn Nominal, records: &[Record]) -> bool {
    let followed: Result<Vec<Record>, _> = records.iter().map(|log| follower.record(log)).collect();
    let Ok(followed) = followed else { return false };
    let suspects: &Vec<Candidate> = &Vec::new();
    let case = |nominal, logs| Case { nominal, suspects, logs, held_out: &[] };
    saw_the_log(&case(follower, &followed), &case(closed, records), Horizon::FreeRun)
}

/// Noise of a signal: as stated, or that of third differences; at least that of rounding to the steps that it is logged in.
fn noise(signal: &[f64], stated: Option<f64>) -> f64 {
    let noise = stated.or_else(|| robust_third_difference_floor(signal)).unwrap_or(0.0);
    let rounding = grid_step(signal).unwrap_or(0.0) / 12.0_f64.sqrt();
    let finite: Vec<f64> = signal.iter().copied().filter(|value| value.is_finite()).collect();
    let size = fd_numeric::rms(finite.iter().copied());
    noise.max(rounding).max(EXACT * size).max(f64::MIN_POSITIVE.sqrt())
}

/// Whether a model leaves its initial state by itself within this time, without inputs or with their means. A pole
/// that falls over and swings below does not run away, but what it does there has nothing to do with the log; a ball
/// below a magnet is unstable only while there is a current.
fn falls_over(model: &Model, inputs: &[[f64; 2]], seconds: f64) -> bool {
    let initial = OperatingPoint::initial(model);
    let held = OperatingPoint {
        u: inputs.iter().map(|[mean, _]| *mean).collect(),
        ..OperatingPoint::initial(model)
    };
    [initial, held].iter().any(|at| {
        let pole = linearize(model, at).ok().and_then(|linear| linear.worst_pole().ok().flatten());
        pole.is_some_and(|pole| FALLS_OVER.ln() < pole.re * seconds)
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failure here is a failed test")]
mod tests {
    use fd_model::{Channel, signal::WhiteNoise};

    use super::*;

    /// A rod that starts upright or hanging, held in a log of ten seconds; it swings when nobody holds it.
    fn is_followed(angle: &str) -> bool {
        let text = format!(
            r#"
            version = 1
            kind = "equations"
            name = "rod"
            sample_time = 0.02
            inputs = {{ u = {{ unit = "1/s^2" }} }}
            outputs = {{ y = {{ unit = "rad", value = "q" }} }}
            [states]
            q = {{ unit = "rad", initial = {angle}, derivative = "w" }}
            w = {{ unit = "rad/s", initial = 0.0, derivative = "9*sin(q) - 0.3*w + u" }}
            "#
        );
        let model: Model = text.parse().unwrap();
        let (u, y) = ([Channel::new("u", "1/s^2")], [Channel::new("y", "rad")]);
        let row = |k: u32| ([(0.3 * f64::from(k)).sin()], [1e-3 * f64::from(k * 7919 % 13)]);
        let ts = model.sample_time().unwrap();
        let log = Record::from_rows(u.to_vec(), y.to_vec(), (0..500).map(row), ts).unwrap();
        follow(&model, &[log]).unwrap().is_some()
    }

    /// A ball that a current holds below a magnet; without one it only falls.
    #[test]
    fn what_is_unstable_with_its_inputs_is_followed() {
        let model: Model = r#"
            version = 1
            kind = "equations"
            name = "ball"
            sample_time = 0.002
            inputs = { i = { unit = "A" } }
            outputs = { gap = { unit = "m", value = "z" } }
            [states]
            z = { unit = "m", initial = 0.01, derivative = "v" }
            v = { unit = "m/s", initial = 0.0, derivative = "9.81 - 9.81e-4*i^2/max(z, 0.001)^2*0.1" }
            "#
        .parse()
        .unwrap();
        let (u, y) = ([Channel::new("i", "A")], [Channel::new("gap", "m")]);
        let row = |k: u32| ([1.0], [0.01 + 1e-5 * f64::from(k * 7919 % 13)]);
        let ts = model.sample_time().unwrap();
        let log = Record::from_rows(u.to_vec(), y.to_vec(), (0..500).map(row), ts).unwrap();
        assert!(follow(&model, &[log]).unwrap().is_some());
    }

    /// A value that stands still between steps has no third differences, and is not exact for that.
    #[test]
    fn what_is_logged_in_steps_is_as_noisy_as_these() {
        let coarse: Vec<f64> = (0..400)
            .map(|k| (0.05 * f64::from(k)).sin())
            .map(|x| 0.2 * (x / 0.2).round())
            .collect();
        assert_eq!(robust_third_difference_floor(&coarse), Some(0.0));
        let step = 0.2 / 12.0_f64.sqrt();
        // A grid is known to a rounding.
        assert!((noise(&coarse, None) - step).abs() < 1e-12);
        assert!((noise(&coarse, Some(0.01)) - step).abs() < 1e-12);
        assert!((noise(&coarse, Some(0.5)) - 0.5).abs() < 1e-12);
    }

    /// A state that runs to infinity within a second, held by somebody: the run that follows it stays near it.
    #[test]
    fn what_is_far_from_linear_is_held() {
        let model: Model = r#"
            version = 1
            kind = "equations"
            name = "runaway"
            sample_time = 0.05
            inputs = { u = { unit = "1/s" } }
            outputs = { y = { unit = "1", value = "x", noise = 0.01 } }
            [states]
            x = { unit = "1", initial = 0.3, tolerance = 0.01, derivative = "2*x + 4*x^3 + u" }
            "#
        .parse()
        .unwrap();
        let mut x = 0.3;
        let row = |k: u32| {
            let u = -6.0 * x + 0.9 * (0.2 * f64::from(k)).sin();
            let y = x + 0.01 * f64::from(k * 7919 % 13 % 3) - 0.01;
            // A hundred Euler steps; the largest rate is 6/s.
            for _ in 0..100 {
                x += 5e-4 * (2.0 * x + 4.0 * x * x * x + u);
            }
            ([u], [y])
        };
        let rows: Vec<([f64; 1], [f64; 1])> = (0..800).map(row).collect();
        let ts = model.sample_time().unwrap();
        let (u, y) = ([Channel::new("u", "1/s")], [Channel::new("y", "1")]);
        let log = Record::from_rows(u.to_vec(), y.to_vec(), rows, ts).unwrap();
        let follower = follow(&model, std::slice::from_ref(&log)).unwrap().unwrap();
        let followed = follower.record(&log).unwrap();
        let inputs: Vec<f64> = (0..800).flat_map(|k| followed.u(k).to_vec()).collect();
        let scales = follower.scales(ts, &inputs, 800).unwrap();
        assert!(scales.outputs[0].peak() < 2.0, "{:?}", scales.outputs);
    }

    /// A pole with its controller in the model, which acts on what its sensor shows: with noise in it, or before noise is
    /// added to the log.
    #[test]
    fn a_controller_of_a_plant_that_falls_over_sees_the_log_where_it_did() {
        let model: Model = r#"
            version = 1
            kind = "equations"
            name = "pole"
            sample_time = 0.02
            inputs = { u = { unit = "1/s^2" } }
            outputs = { y = { unit = "rad", value = "q", noise = 0.002 } }
            [states]
            q = { unit = "rad", initial = 0.0, derivative = "w" }
            w = { unit = "rad/s", initial = 0.0, derivative = "9*sin(q) - 0.3*w + u" }
            [controller]
            sample_time = 0.02
            references = { r = { unit = "rad" } }
            states = { before = { unit = "rad", initial = 0.0, update = "y" } }
            signals = { u = "40*(r - y) - 6*(y - before)/0.02" }
            "#
        .parse()
        .unwrap();
        let ts = model.sample_time().unwrap();
        let (r, y) = ([Channel::new("r", "rad")], [Channel::new("y", "rad")]);
        let noise = WhiteNoise::new(0.002, 3).values(600).unwrap();
        for is_in_loop in [true, false] {
            let (mut q, mut w, mut before) = (0.0_f64, 0.0_f64, 0.0);
            let row = |k: usize| {
                let r = 0.1 * (0.5 * k as f64 * 0.02).sin().signum();
                let shown = q + noise[k];
                let seen = if is_in_loop { shown } else { q };
                let u = 40.0 * (r - seen) - 6.0 * (seen - before) / 0.02;
                before = seen;
                // A hundred Euler steps; the largest rate is 7/s.
                for _ in 0..100 {
                    (q, w) = (q + 2e-4 * w, w + 2e-4 * (9.0 * q.sin() - 0.3 * w + u));
                }
                ([r], [shown])
            };
            let rows: Vec<([f64; 1], [f64; 1])> = (0..600).map(row).collect();
            let log = Record::from_rows(r.to_vec(), y.to_vec(), rows, ts).unwrap();
            let follower = follow(&model, std::slice::from_ref(&log)).unwrap();
            assert_eq!(follower.is_some(), is_in_loop);
            let Some(follower) = follower else { continue };
            // What is left is the noise of the sensor and a little of the filter.
            let seen = follower.record(&log).unwrap();
            let mut simulator = follower.simulator(ts).unwrap();
            let u: Vec<f64> = (0..600).flat_map(|k| seen.u(k).to_vec()).collect();
            let mut simulated = vec![0.0; 600];
            simulator.simulate(&[], &model.initial(), &u, &mut simulated);
            let errors = simulated.iter().zip(log.output(0)).skip(100).map(|(s, y)| s - y);
            let left = fd_numeric::rms(errors);
            assert!((0.0018..0.0045).contains(&left), "{left}");
        }
    }

    #[test]
    fn what_falls_over_and_swings_is_followed_and_what_hangs_is_not() {
        assert!(is_followed("0.0"));
        assert!(!is_followed("3.14159265"));
    }
}
