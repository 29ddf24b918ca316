//! The linear engine as a simulator, settled where its health says.

use fd_jetengine::engine17::{
    Engine17, Health, HealthParameter, MEASURED, NX, Parameters, Trim, input_channels,
    state_channels,
};
use fd_model::{
    Channel, ChannelScale, StateSpace,
    file::{LinearModel, LinearSystem, ModelChannel},
};
use fd_sim::{
    equation::Expr,
    model::{Definition, LinearOptions, Model},
};

use super::{EngineKnowledge, EnginePlantError};

/// Shift of a health parameter for the parabola of its settled points: where logs of worn engines
/// lie, and large enough that trims, exact to 1e-12, leave no error in the curvature.
const SHIFT: f64 = 0.01;

/// The engine linearised where logs begin and sampled like them, as equations. Measured are
/// deviations from the point in which the engine, in the health that it has, settles at the fuel
/// flow where logs begin: for each parameter of its [`Health`] a parabola through three trims. A
/// change of health thus shifts the outputs and leaves the dynamics as they are.
///
/// Uncertain are the parameters of the health as far as the [`EngineKnowledge`] says, and, for what
/// linearisation loses, a gain per output and the speed of the whole.
///
/// *When not to use:* logs that do not begin settled, or leave the operating point by more than a
/// few percent; effects of two health parameters together, of which the parabolas lack the product.
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
    let sampled = engine.linearise(&trim)?.per_unit()?.model.sample_zoh(known.ts)?;
    let rows: Vec<usize> = known.outputs.iter().filter(|i| **i < sampled.ny()).copied().collect();
    let pick = |all: faer::MatRef<'_, f64>| {
        faer::Mat::from_fn(rows.len(), all.ncols(), |i, j| all[(rows[i], j)])
    };
    let (a, b) = (sampled.a().to_owned(), sampled.b().to_owned());
    let measured = StateSpace::new(a, b, pick(sampled.c()), pick(sampled.d()), sampled.domain())?;
    let scaled = |channels: Vec<Channel>, point: &[f64]| -> Vec<ModelChannel> {
        let pairs = channels.into_iter().zip(point);
        let scale = |point: &f64| ChannelScale::per_unit(*point, *point);
        pairs.map(|(channel, p)| ModelChannel { channel, scale: scale(p) }).collect()
    };
    let states = state_channels().into_iter();
    let states = states.map(|c| Channel::new(format!("{}_deviation", c.name), c.unit)).collect();
    let settled: Vec<f64> = rows.iter().map(|i| trim.outputs()[*i]).collect();
    let file = LinearModel {
        name: Some("engine17, linear".to_owned()),
        inputs: scaled(input_channels(), &[trim.fuel]),
        states: scaled(states, &trim.x),
        outputs: scaled(known.output_channels(), &settled),
        system: LinearSystem::Discrete(measured),
        allow_unstable: false,
    };
    let options = LinearOptions { noise: noise.to_vec(), ..LinearOptions::default() };
    let mut draft = Model::from_linear(&file, known.ts, &options)?.into_draft();
    draft.parameters.splice(0..0, known.parameters());
    let parabolas = HealthParameter::ALL
        .into_iter()
        .map(|parameter| Parabola::of(&engine, &trim, parameter))
        .collect::<Result<Vec<_>, _>>()?;
    for (row, output) in rows.into_iter().zip(&mut draft.outputs) {
        let name = format!("{}_settled", output.name);
        let shift = parabolas.iter().map(|parabola| parabola.expr(MEASURED[row]));
        let shift = shift.reduce(|sum, term| sum + term).unwrap_or(Expr::Number(0.0));
        let point = Expr::Number(trim.x[MEASURED[row]]);
        output.value = output.value.clone() + Expr::name(&name);
        draft.definitions.push(Definition { name, value: point * shift });
    }
    Ok(Model::try_from(draft)?)
}

/// Where the engine settles as one parameter of its health shifts, relative to where it settles
/// without.
struct Parabola {
    parameter: HealthParameter,
    slope: [f64; NX],
    bend: [f64; NX],
}

impl Parabola {
    fn of(
        engine: &Engine17<f64>,
        trim: &Trim,
        parameter: HealthParameter,
    ) -> Result<Self, EnginePlantError> {
        let settled = |shift: f64| {
            let health = Health::default().shifted(parameter, shift);
            engine.clone().with_health(health).trim_from(trim.fuel, &trim.x)
        };
        let (up, down) = (settled(SHIFT)?.x, settled(-SHIFT)?.x);
        let relative = |i: usize| [up[i] / trim.x[i] - 1.0, down[i] / trim.x[i] - 1.0];
        Ok(Self {
            parameter,
            slope: std::array::from_fn(|i| (relative(i)[0] - relative(i)[1]) / (2.0 * SHIFT)),
            bend: std::array::from_fn(|i| {
                (relative(i)[0] + relative(i)[1]) / (2.0 * SHIFT * SHIFT)
            }),
        })
    }

    /// `slope e + bend e^2` of a state, where `e` is the shift of the parameter.
    fn expr(&self, state: usize) -> Expr {
        let nominal = Health::<f64>::default().get(self.parameter);
        let name = Expr::name(self.parameter.name());
        let shift = if nominal == 0.0 { name } else { name - Expr::Number(nominal) };
        let bent = Expr::Number(self.slope[state]) + Expr::Number(self.bend[state]) * shift.clone();
        bent * shift
    }
}
