//! Long inputs, and an engine that becomes another one.

use fd_core::Heap;
use fd_model::{Discrete, Inputs, Record, Simulation, SimulationError, StateSpace};
use rand::Rng;

use crate::engine::{
    benchmark::{Benchmark, Case, Draw},
    error::EngineStudyError,
    reality::Reality,
};

/// Steps in which a drift goes.
const STEPS: usize = 20;
/// Engines that are drawn until the way to one is stable.
const DRAWS: usize = 100;

/// A drift: plants, each from a sample on.
pub(super) type Way = Vec<(usize, Reality)>;

impl Benchmark {
    /// A long input without jumps but the steps of a fresh run, with noise.
    pub(super) fn draw_long(
        &self,
        case: &mut Case,
        samples: usize,
    ) -> Result<Draw, EngineStudyError> {
        let fresh = &self.config().fresh;
        let inputs = fresh.long_inputs(self.inputs(), self.ts(), samples, &mut case.rng)?;
        Ok(Draw { inputs, output_noise: self.noise(&mut case.rng) })
    }

    /// The same input up to a sample, and from there on fresh runs one after the other: where two are joined, level
    /// and tones jump further than within any of them.
    pub(super) fn with_jumps(
        &self,
        case: &mut Case,
        draw: &Draw,
        from: usize,
    ) -> Result<Draw, EngineStudyError> {
        let (inputs, nu) = (&draw.inputs, self.inputs().len());
        let mut u = inputs.values()[..from.min(inputs.len()) * nu].to_vec();
        while u.len() < inputs.len() * nu {
            let run = self.config().fresh.inputs(self.inputs(), self.ts(), &mut case.rng)?;
            // A run begins with a sample at rest, which would be a spike here.
            let rest = run.values().get(nu..).unwrap_or_default();
            if rest.is_empty() {
                return Err(EngineStudyError::None { setting: "fresh.duration_s" });
            }
            u.extend_from_slice(rest);
        }
        u.truncate(inputs.len() * nu);
        let inputs = Inputs::new(self.inputs().to_vec(), u, inputs.len(), inputs.ts())?;
        Ok(Draw { inputs, output_noise: draw.output_noise.clone() })
    }

    /// The first samples of a long run.
    pub(super) fn shorter(draw: &Draw, samples: usize) -> Result<Draw, EngineStudyError> {
        let inputs = part(&draw.inputs, 0, samples.min(draw.inputs.len()))?;
        Ok(Draw { inputs, output_noise: draw.output_noise.clone() })
    }

    /// The way of the plant of a case to another engine, from sample `from` on for `length` samples.
    pub(super) fn way(
        &self,
        case: &mut Case,
        from: usize,
        length: usize,
    ) -> Result<Option<Way>, EngineStudyError> {
        let Some(plant) = case.plant.clone() else { return Ok(None) };
        for _ in 0..DRAWS {
            let other = self.perturbed(case.rng.next_u64())?.model.model.sample_zoh(self.ts())?;
            let mut way = Vec::new();
            let mut is_stable = true;
            for step in 1..=STEPS {
                let share = self.config().on_line.drift * step as f64 / STEPS as f64;
                let blend = between(&plant, &other, share)?;
                is_stable &= blend.poles()?.iter().all(|pole| pole.norm() < 1.0);
                let since = from + length * (step - 1) / STEPS;
                way.push((since, Reality::Linear(blend.freeze::<f64, Heap>()?)));
            }
            if is_stable {
                return Ok(Some(way));
            }
        }
        Ok(None)
    }

    /// A run of the plant of a case that goes such a way.
    pub(super) fn drifting_run(
        &self,
        case: &Case,
        draw: &Draw,
        way: &Way,
    ) -> Result<Record, EngineStudyError> {
        let (inputs, n) = (&draw.inputs, draw.inputs.len());
        let mut x = case.training.rest();
        let mut y = Vec::new();
        let begins = std::iter::once((0, &case.training)).chain(way.iter().map(|(k, p)| (*k, p)));
        let ends = way.iter().map(|(k, _)| *k).chain([n]);
        for ((from, plant), to) in begins.zip(ends) {
            let (from, to) = (from.min(n), to.min(n));
            let simulation = Simulation { x0: x.clone(), ..Simulation::default() };
            let stretch = plant.run(simulation, &part(inputs, from, to)?, self.outputs())?;
            y.extend(stretch.samples().flat_map(|(_, y)| y.iter().copied()));
            plant.advance(&mut x, inputs, from..to);
        }
        let ny = self.outputs().len();
        for (i, noise) in draw.output_noise.iter().enumerate() {
            let values = noise.values(n, inputs.ts()).map_err(SimulationError::from)?;
            y.iter_mut().skip(i).step_by(ny).zip(values).for_each(|(y, noise)| *y += noise);
        }
        let u = inputs.values().to_vec();
        Ok(Record::new(inputs.channels().to_vec(), self.outputs(), u, y, inputs.ts())?)
    }
}

fn part(inputs: &Inputs, from: usize, to: usize) -> Result<Inputs, EngineStudyError> {
    let nu = inputs.channels().len();
    let u = inputs.values()[from * nu..to * nu].to_vec();
    Ok(Inputs::new(inputs.channels().to_vec(), u, to - from, inputs.ts())?)
}

/// Entry by entry, `share` of the way from one plant to another.
fn between(
    one: &StateSpace<Discrete>,
    other: &StateSpace<Discrete>,
    share: f64,
) -> Result<StateSpace<Discrete>, EngineStudyError> {
    let blend = |a: faer::MatRef<'_, f64>, b: faer::MatRef<'_, f64>| {
        faer::Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] + share * (b[(i, j)] - a[(i, j)]))
    };
    Ok(StateSpace::new(
        blend(one.a(), other.a()),
        blend(one.b(), other.b()),
        blend(one.c(), other.c()),
        blend(one.d(), other.d()),
        one.domain(),
    )?)
}
