//! The linear engine as a simulator, with a site for each parameter of its health.

use fd_gap::{
    equation::Expr,
    model::{LinearOptions, Model, Site},
};
use fd_jetengine::engine17::{
    Engine17, Health, HealthParameter, NX, Parameters, Trim, input_channels, output_channels,
    state_channels,
};
use fd_model::{
    Channel, ChannelScale, Continuous, StateSpace,
    file::{LinearModel, LinearSystem, ModelChannel},
};

use super::{EngineKnowledge, EnginePlantError};

/// Shift of a health parameter for its slopes: 1e-4 of 1, for an error of 1e-8 from curvature and
/// of about 1e-11 from rounding.
const STEP: f64 = 1e-4;
/// How well the state is known in which a log begins, per unit: a worn engine settles elsewhere.
const INITIAL_TOLERANCE: f64 = 0.02;

/// The engine linearised where logs begin and sampled like them, as equations. Every parameter of
/// its [`Health`] is a site at which a shift of the parameter acts as a force, so that effects on
/// the health can be spliced in.
///
/// What is unknown besides is a gain per output, the speed of the whole, and the initial state.
///
/// # Errors
///
/// Returns an error when the engine cannot be trimmed at the fuel flow.
pub fn linear_engine(
    known: &EngineKnowledge,
    noise: &[Option<f64>],
) -> Result<Model, EnginePlantError> {
    let engine = Engine17::new(&Parameters::default())?;
    let trim = engine.trim(known.fuel)?;
    let per_unit = engine.linearise(&trim)?.per_unit()?;
    let linear = &per_unit.model;
    let slopes: Vec<[f64; NX]> =
        HealthParameter::ALL.iter().map(|p| slope(&engine, &trim, *p)).collect();
    let with_health = StateSpace::new(
        linear.a().to_owned(),
        faer::Mat::from_fn(NX, 1 + slopes.len(), |i, j| match j {
            0 => linear.b()[(i, 0)],
            j => slopes[j - 1][i],
        }),
        linear.c().to_owned(),
        faer::Mat::zeros(linear.ny(), 1 + slopes.len()),
        Continuous,
    )?
    .sample_zoh(known.ts)?;
    let sampled = StateSpace::new(
        with_health.a().to_owned(),
        with_health.b().subcols(0, 1).to_owned(),
        with_health.c().to_owned(),
        with_health.d().subcols(0, 1).to_owned(),
        with_health.domain(),
    )?;
    let scaled = |channels: Vec<Channel>, point: &[f64]| -> Vec<ModelChannel> {
        let pairs = channels.into_iter().zip(point);
        let scale = |point: &f64| ChannelScale::per_unit(*point, *point);
        pairs.map(|(channel, p)| ModelChannel { channel, scale: scale(p) }).collect()
    };
    let states = state_channels().into_iter();
    let states = states.map(|c| Channel::new(format!("{}_deviation", c.name), c.unit)).collect();
    let file = LinearModel {
        name: Some("engine17, linear".to_owned()),
        inputs: scaled(input_channels(), &[trim.fuel]),
        states: scaled(states, &trim.x),
        outputs: scaled(output_channels(), &trim.outputs()),
        system: LinearSystem::Discrete(sampled),
        allow_unstable: false,
    };
    let options = LinearOptions {
        initial_tolerance: Some(INITIAL_TOLERANCE),
        noise: noise.to_vec(),
        ..LinearOptions::default()
    };
    let mut draft = Model::from_linear(&file, known.ts, &options)?.into_draft();
    for (i, parameter) in HealthParameter::ALL.into_iter().enumerate() {
        let factor = |state: usize| Expr::Number(with_health.b()[(state, 1 + i)]);
        let enters = (0..NX).map(|state| (draft.states[state].name.clone(), factor(state)));
        let (name, enters) = (parameter.name().to_owned(), enters.collect());
        let unit = "1".to_owned();
        draft.sites.push(Site { name, unit, enters, position: None, velocity: None });
    }
    Ok(Model::try_from(draft)?)
}

/// Rates of the relative deviations per shift of a health parameter, per second.
fn slope(engine: &Engine17<f64>, trim: &Trim, parameter: HealthParameter) -> [f64; NX] {
    let rates = |shift: f64| {
        let health = Health::default().shifted(parameter, shift);
        engine.clone().with_health(health).rhs(&trim.x, trim.fuel)
    };
    let (up, down) = (rates(STEP), rates(-STEP));
    std::array::from_fn(|i| (up[i] - down[i]) / (2.0 * STEP) / trim.x[i])
}
