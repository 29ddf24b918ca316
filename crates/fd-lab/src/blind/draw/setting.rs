//! Draws the conditions under which logs are taken.

use crate::blind::{
    conditions::Conditions,
    controller::{Action, Controller},
    error::BlindError,
    kind::CaseKind,
    logger::Logger,
    misreading::Misreading,
    plants::{Tuning, looped},
    random::Random,
    truth::{Scene, Truth},
};
use fd_sim::model::Model;

/// Samples before a log that begins in motion, in samples of the log.
const BEFORE: [f64; 2] = [0.2, 0.8];
/// Steps of a coarse logger, in standard deviations of the noise.
const STEPS: [f64; 2] = [1.5, 60.0];
/// What a jittering clock adds to the noise of the output that it hurts most, in that noise.
const JITTER: [f64; 2] = [0.3, 2.0];
/// Share of commands at their limits above which a linear controller is too strong.
const LIMITED: f64 = 0.3;
/// How often a controller that is too strong is made half as strong.
const HALVINGS: usize = 5;

/// The conditions of a case whose plant, excitation and seed are drawn; `None` when nothing comes
/// of it.
pub(super) fn conditions(
    truth: &Truth,
    model: &Model,
    random: &mut Random,
) -> Result<Option<Conditions>, BlindError> {
    let plain = Conditions::default();
    let (kind, samples) = (truth.kind, truth.samples as f64);
    Ok(Some(match kind {
        _ if kind.is_looped() => {
            let controller = controller(truth, model, random)?;
            return Ok(controller.map(|c| Conditions { controller: Some(c), ..plain }));
        }
        CaseKind::Cut | CaseKind::CutNone => Conditions { is_cut: true, ..plain },
        CaseKind::InMotion | CaseKind::InMotionNone => {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share")]
            let before = (samples * random.uniform(BEFORE[0], BEFORE[1])) as usize;
            Conditions { before, ..plain }
        }
        CaseKind::Coarse | CaseKind::CoarseNone => {
            let logger = Some(coarse(&Scene::new(truth, model)?, random));
            Conditions { logger, ..plain }
        }
        CaseKind::Patchy | CaseKind::PatchyNone => {
            let logger = Some(patchy(&Scene::new(truth, model)?, random));
            Conditions { logger, ..plain }
        }
        CaseKind::Misread => {
            Conditions { misreading: Some(Misreading::draw(model, random)), ..plain }
        }
        _ => plain,
    }))
}

/// Steps for at least one output, and a range that is too short for some.
fn coarse(scene: &Scene<'_>, random: &mut Random) -> Logger {
    let outputs = &scene.model.outputs;
    let always = random.below(outputs.len());
    let mut logger = Logger { seed: random.seed(), ..Logger::default() };
    for (c, output) in outputs.iter().enumerate() {
        let is_coarse = c == always || random.unit() < 0.5;
        let step = output.noise.unwrap_or(0.0) * random.log_uniform(STEPS[0], STEPS[1]);
        logger.steps.push(if is_coarse { step } else { 0.0 });
        let signal = &scene.scales.outputs[c];
        let (is_short, span) = (random.unit() < 0.3, signal.high - signal.low);
        let [low, high] = [0.08, 0.08].map(|most| span * most * random.unit());
        logger.ranges.push(is_short.then_some([signal.low + low, signal.high - high]));
    }
    logger
}

/// A clock that jitters, holes, and lost rows.
fn patchy(scene: &Scene<'_>, random: &mut Random) -> Logger {
    let outputs = scene.model.outputs.iter().zip(&scene.scales.outputs);
    let hurt = outputs.map(|(output, signal)| signal.slope / output.noise.unwrap_or(1.0));
    let most = hurt.fold(1e-12, f64::max);
    Logger {
        jitter: (random.log_uniform(JITTER[0], JITTER[1]) / most).min(0.5),
        missing: random.uniform(0.0, 0.1),
        lost: random.uniform(0.0, 0.05),
        seed: random.seed(),
        ..Logger::default()
    }
}

/// A controller that holds the plant, and does not only hit its limits.
fn controller(
    truth: &Truth,
    model: &Model,
    random: &mut Random,
) -> Result<Option<Controller>, BlindError> {
    let Some(mut drawn) = drawn(truth, model, random)? else { return Ok(None) };
    for _ in 0..HALVINGS {
        let conditions = Conditions { controller: Some(drawn.clone()), ..Conditions::default() };
        let truth = Truth { conditions, ..truth.clone() };
        let scene = Scene::new(&truth, model)?;
        let x0 = scene.initial(0);
        if let Some(trace) = scene.trace(&[], &truth.parameters, &x0, 0, true)? {
            let nu = model.inputs.len();
            let commands: Vec<f64> =
                trace.commands.iter().skip(drawn.input).step_by(nu).copied().collect();
            let is_at_limit = |u: &&f64| 0.99 * drawn.limit <= (**u - drawn.trim).abs();
            let limited = commands.iter().filter(is_at_limit).count() as f64;
            let is_strong = LIMITED * commands.len() as f64 <= limited;
            let ny = model.outputs.len();
            let far = trace.clean.iter().skip(drawn.output).step_by(ny);
            let [middle, size] = drawn.reference;
            let is_held = far.fold(0.0, |far: f64, y| far.max((y - middle).abs())) < 12.0 * size;
            if is_held && (!is_strong || drawn.action == Action::BangBang) {
                return Ok(Some(drawn));
            }
        }
        // An unstable plant needs what it needs.
        if truth.kind.is_unstable() {
            return Ok(None);
        }
        for gain in [&mut drawn.gain, &mut drawn.integral, &mut drawn.rate] {
            *gain *= 0.5;
        }
    }
    Ok(None)
}

fn drawn(
    truth: &Truth,
    model: &Model,
    random: &mut Random,
) -> Result<Option<Controller>, BlindError> {
    let Some(looped) = super::plants::plant(&truth.plant).and_then(looped) else { return Ok(None) };
    let [input, output] = looped.ends;
    let actions = if truth.kind.is_unstable() {
        vec![Action::Pid, Action::StateFeedback, Action::BangBang]
    } else {
        let mut all = vec![Action::Proportional, Action::Pid, Action::StateFeedback];
        all.extend([Action::BangBang, Action::Human]);
        all
    };
    let action = actions[random.below(actions.len())];
    let drive = looped.plant.drives[input];
    let ts = model.sample_time;
    let time = 1.0 / (std::f64::consts::TAU * (drive.band[0] * drive.band[1]).sqrt());
    let noise = model.outputs[output].noise.unwrap_or(0.0);
    let spread = |random: &mut Random| random.log_uniform(0.7, 1.4);
    // Command per error, its rate, against the rate of the output; limit; reference.
    let (gains, reference, inner) = match looped.tuning {
        Tuning::Fixed { gains: [k, i, d, limit], reference, .. } => {
            let (k, i, d) = (k * spread(random), i * spread(random), d * spread(random));
            ([k, i, d, limit], reference, None)
        }
        Tuning::Relative => {
            let scene = Scene::new(truth, model)?;
            let (u, y) = (&scene.scales.inputs[input], &scene.scales.outputs[output]);
            let unit = u.std / y.std;
            let k = unit * random.log_uniform(0.5, 2.5);
            let (i, d) =
                (k / (time * random.uniform(1.0, 4.0)), k * time * random.uniform(0.1, 0.6));
            let limit = 1.5 * drive.amplitude;
            let inner = looped.inner.map(|place| {
                let signal = &scene.scales.outputs[place];
                (place, random.uniform(0.1, 0.4) * u.std / signal.std, signal.mean)
            });
            ([k, i, d, limit], [y.mean, 1.2 * y.std], inner)
        }
    };
    let [gain, integral, rate, limit] = gains;
    let is_unstable = truth.kind.is_unstable();
    let at_rest = |output: usize| {
        let value = |name: &str| {
            let state = model.states.iter().find(|s| s.name == name).map(|s| s.initial);
            state.or_else(|| model.parameter(name).map(|p| p.value))
        };
        model.outputs[output].value.evaluate(&value).unwrap_or(0.0)
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
    let looks = |times: f64| ((times * time / ts).round() as usize).max(2);
    let filter = (time * random.uniform(0.05, 0.15)).max(2.0 * ts);
    let own = |wanted: bool, value: f64| if wanted { value } else { 0.0 };
    Ok(Some(Controller {
        action,
        input,
        output,
        trim: drive.centre,
        gain: if action == Action::Human { gain * random.uniform(0.3, 0.7) } else { gain },
        integral: own(action == Action::Pid, integral),
        rate: own(
            matches!(action, Action::Pid | Action::StateFeedback)
                || action == Action::BangBang && is_unstable,
            rate,
        ),
        inner: inner.filter(|_| action == Action::StateFeedback),
        band: match action {
            Action::BangBang => (reference[1] * random.uniform(0.02, 0.1)).max(2.0 * noise),
            _ => reference[1] * random.uniform(0.02, 0.15),
        },
        limit: if action == Action::BangBang { limit * random.uniform(0.4, 0.8) } else { limit },
        pole: (-ts / if is_unstable { ts } else { filter }).exp(),
        looks: [looks(random.uniform(0.8, 2.0)), looks(random.uniform(0.2, 0.6))],
        rest: at_rest(output),
        reference,
        seed: random.seed(),
    }))
}
