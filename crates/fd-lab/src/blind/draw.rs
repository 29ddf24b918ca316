//! Draws cases: a plant, an excitation, conditions, effects of a strength that is sought.

mod setting;

use fd_sim::{equation::Expr, model::Model};

use super::{
    conditions::Conditions,
    error::BlindError,
    excitation::Shape,
    kind::CaseKind,
    laws::{Law, Needs, Place, catalogue},
    oracle::left_by_nothing,
    plants,
    random::{Random, named_seed},
    strength::{Yardstick, seek},
    truth::{Effect, Scene, Truth},
};

/// Squares of the noise that effects are to leave: from barely visible to large.
const TARGETS: [f64; 2] = [12.0, 1.5e5];
/// A distance above so many times the wanted one: the weakest effect of the law is too strong.
const TOO_STRONG: f64 = 10.0;
/// How well the level of the noise is known, as a share of it.
const NOISE_LEVEL: f64 = 0.1;
/// The same for each of two effects: both must show.
const PAIR_TARGETS: [f64; 2] = [150.0, 5e4];
/// The same for one dominant effect, and how many times less each of the others leaves.
const DOMINANT: [f64; 2] = [3e3, 5e4];
const SMALLER: [f64; 2] = [15.0, 60.0];
/// Less is not worth a case.
const VISIBLE: f64 = 9.0;
/// Share of coloured noise among cases with an effect.
const COLOURED: f64 = 0.2;
/// Squares of the noise that a mistake of reading leaves at least.
const READABLE: f64 = 100.0;
/// How often a case is drawn anew when nothing comes of it.
const TRIES: usize = 40;

/// Draws a case; everything follows from the seed, the kind and the number.
pub(super) fn draw(
    seed: u64,
    kind: CaseKind,
    number: usize,
    samples: usize,
) -> Result<(Truth, Model), BlindError> {
    for attempt in 0..TRIES {
        let name = format!("{}/{number}/{attempt}", kind.name());
        if let Some(drawn) = attempt_at(named_seed(seed, &name), kind, number, samples)? {
            return Ok(drawn);
        }
    }
    Err(BlindError::NothingSuits { kind: kind.name(), tries: TRIES })
}

fn attempt_at(
    seed: u64,
    kind: CaseKind,
    number: usize,
    samples: usize,
) -> Result<Option<(Truth, Model)>, BlindError> {
    let random = &mut Random::new(seed);
    let plants = plants::of_kind(kind);
    let weights: usize = plants.iter().map(|plant| plant.weight).sum();
    let mut place = random.below(weights);
    let plant = plants.iter().find(|plant| {
        let is_here = place < plant.weight;
        place = place.saturating_sub(plant.weight);
        is_here
    });
    let Some(plant) = plant else { return Ok(None) };
    let model = plant.model()?;
    let off = model.parameters.iter().map(|p| {
        let error = p.tolerance.min(0.03) * random.uniform(-1.0, 1.0);
        p.value * (1.0 + error)
    });
    let parameters = off.collect();
    let coloured = match kind {
        kind if kind.is_null() => number % 2 == 1,
        _ => random.unit() < COLOURED,
    };
    let mut truth = Truth {
        case: String::new(),
        kind,
        plant: plant.name.to_owned(),
        excitation: Shape::ALL[random.below(Shape::ALL.len())],
        samples,
        coloured,
        noise_factor: random.uniform(1.0 - NOISE_LEVEL, 1.0 + NOISE_LEVEL),
        seed: random.seed(),
        parameters,
        effects: Vec::new(),
        conditions: Conditions::default(),
        oracle: None,
    };
    if !kind.is_plain() {
        let random = &mut Random::named(truth.seed, "conditions");
        let Some(drawn) = setting::conditions(&truth, &model, random)? else { return Ok(None) };
        truth.conditions = drawn;
    }
    if kind == CaseKind::Misread && left_by_nothing(&truth, &model)? < READABLE {
        return Ok(None);
    }
    let scene = Scene::new(&truth, &model)?;
    let yardstick = if truth.conditions.is_plain() {
        let Some(yardstick) = Yardstick::new(&scene)? else { return Ok(None) };
        Some(yardstick)
    } else {
        None
    };
    let mut effects: Vec<Effect> = Vec::new();
    while effects.len() < kind.effects() {
        let [low, high] = match (kind, effects.first()) {
            (CaseKind::Dominant, None) => DOMINANT,
            (CaseKind::Dominant, Some(first)) => SMALLER.map(|times| first.distance / times),
            (CaseKind::Pair, _) => PAIR_TARGETS,
            _ => TARGETS,
        };
        let target = random.log_uniform(low, high);
        // What corrupts the measurement leaves no trace in a replay without noise.
        let is_simulated = 1 < kind.effects() || !truth.conditions.is_plain();
        let suits = |law: &Law| {
            law.origin == kind.origin() && !(is_simulated && law.needs == Needs::Measurement)
        };
        let Some((mut effect, law)) = pick(&scene, random, suits) else { return Ok(None) };
        if effects.iter().any(|e| e.label == effect.label && e.site == effect.site) {
            return Ok(None);
        }
        if law.needs == Needs::Measurement {
            effect.strength = random.log_uniform(law.range[0], law.range[1]);
            effect.distance = shown(&effect, samples);
        } else {
            match &yardstick {
                Some(yardstick) => {
                    seek(&mut effect, target, law.range, &|e| yardstick.distance(e))?;
                }
                None => seek(&mut effect, target, law.range, &|effect| {
                    let effects = vec![effect.clone()];
                    left_by_nothing(&Truth { effects, ..truth.clone() }, &model)
                })?,
            }
            if TOO_STRONG * target < effect.distance {
                return Ok(None);
            }
        }
        if effect.distance < VISIBLE || !effect.distance.is_finite() {
            return Ok(None);
        }
        effects.push(effect);
    }
    drop(yardstick);
    drop(scene);
    truth.effects = effects;
    // Every run that is going to be logged must go well, with noise in the loop and all.
    let scene = Scene::new(&truth, &model)?;
    for (run, is_noisy) in [(0, true), (0, false), (1, true)] {
        if scene.log(run, is_noisy)?.is_none() {
            return Ok(None);
        }
    }
    drop(scene);
    Ok(Some((truth, model)))
}

/// A label that suits the plant, one of its laws, and a place for it.
fn pick(
    scene: &Scene<'_>,
    random: &mut Random,
    suits: impl Fn(&Law) -> bool,
) -> Option<(Effect, Law)> {
    let all: Vec<(Law, Vec<Spot>)> = catalogue()
        .into_iter()
        .filter(|law| suits(law))
        .map(|law| (law, places(scene, &law)))
        .filter(|(_, places)| !places.is_empty())
        .collect();
    let mut labels: Vec<&str> = all.iter().map(|(law, _)| law.label).collect();
    labels.dedup();
    if labels.is_empty() {
        return None;
    }
    let label = labels[random.below(labels.len())];
    let laws: Vec<_> = all.iter().filter(|(law, _)| law.label == label).collect();
    let (law, places) = laws[random.below(laws.len())];
    let (index, partner) = places[random.below(places.len())];
    let model = scene.model;
    let name = |index: usize| match law.place {
        Place::Input => model.inputs[index].name.clone(),
        Place::Force => model.sites[index].name.clone(),
        Place::Parameter => model.parameters[index].name.clone(),
        Place::Output => model.outputs[index].name.clone(),
        Place::Inside => plants::inner(scene.plant)[index].name.to_owned(),
    };
    let partner_name = partner.map(|partner| match law.place {
        Place::Force => model.states[partner].name.clone(),
        _ => name(partner),
    });
    let effect = Effect {
        label: law.label.to_owned(),
        law: law.name.to_owned(),
        family: law.family.to_owned(),
        origin: law.origin,
        place: law.place,
        site: name(index),
        index,
        partner: partner_name,
        partner_index: partner.unwrap_or(index),
        strength: law.range[0],
        shape: [random.unit(), random.unit(), random.unit()],
        seed: random.seed(),
        distance: 0.0,
    };
    Some((effect, *law))
}

/// A place, and the other end where there is one.
type Spot = (usize, Option<usize>);

/// Where a law can be at work: places, each with the other end where there is one.
pub(super) fn places(scene: &Scene<'_>, law: &Law) -> Vec<Spot> {
    let (model, scales) = (scene.model, &scene.scales);
    let alone = |n: usize| (0..n).map(|i| (i, None)).collect::<Vec<_>>();
    let pairs = |n: usize| {
        let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, Some(j))));
        all.filter(|(i, j)| Some(*i) != *j).collect::<Vec<_>>()
    };
    match law.place {
        Place::Input if law.needs == Needs::Partner => pairs(model.inputs.len()),
        Place::Input => alone(model.inputs.len()),
        Place::Inside => alone(plants::inner(scene.plant).len()),
        Place::Output => {
            let n = model.outputs.len();
            let mut all = if law.needs == Needs::Partner { pairs(n) } else { alone(n) };
            // A logged command is what the controller says; no sensor is there.
            let is_sensed = |i: usize| {
                !model.inputs.iter().any(|u| model.outputs[i].value == Expr::name(&u.name))
            };
            all.retain(|(i, j)| is_sensed(*i) && j.is_none_or(is_sensed));
            all
        }
        Place::Parameter => {
            let mut all = alone(model.parameters.len());
            all.retain(|(i, _)| 0.0 < model.parameters[*i].tolerance);
            all
        }
        Place::Force => {
            let mut all = alone(model.sites.len());
            all.retain(|(i, _)| {
                let site = &scales.sites[*i];
                let (x, v) = (site.position.is_some(), site.velocity.is_some());
                let fits = match law.needs {
                    Needs::Velocity => v,
                    Needs::Carrier => model.sites[*i].velocity.is_some(),
                    Needs::Position => x,
                    Needs::Motion => x && v,
                    Needs::Reversal => v && scene.plant.reverses,
                    Needs::Level => x && !v,
                    Needs::Angle => is_angle(model, *i),
                    Needs::Nothing | Needs::Partner => true,
                    Needs::Measurement => false,
                };
                fits && 0.0 < site.force
            });
            if law.needs != Needs::Partner {
                return all;
            }
            let other = |i: usize, state: &str| {
                let site = &model.sites[i];
                let own = [&site.position, &site.velocity].into_iter().flatten();
                let enters = site.enters.iter().any(|(name, _)| name == state);
                !enters && !own.into_iter().any(|expr| expr.mentions(state))
            };
            let states = || model.states.iter().enumerate();
            let with = |(i, _): &Spot| {
                let i = *i;
                let found = states().filter(move |(_, state)| other(i, &state.name));
                found.map(move |(j, _)| (i, Some(j))).collect::<Vec<_>>()
            };
            all.iter().flat_map(with).collect()
        }
    }
}

fn is_angle(model: &Model, site: usize) -> bool {
    let position = model.sites[site].position.as_ref();
    let state = model.states.iter().find(|s| position == Some(&Expr::name(&s.name)));
    state.is_some_and(|state| state.unit == "rad")
}

/// How much a corrupted measurement shows, as twice the logarithm of the likelihood ratio that a
/// perfect observer of the noise would have.
fn shown(effect: &Effect, samples: usize) -> f64 {
    let (n, s) = (samples as f64, effect.strength);
    match effect.label.as_str() {
        // Variance s² instead of 1; but the level of the noise is not known either, and may follow.
        "sensor-noise" => (n * (s * s - 1.0 - 2.0 * s.ln())).min((s.ln() / NOISE_LEVEL).powi(2)),
        // Each outlier is many standard deviations away; five squares for the price of naming it.
        "sensor-outliers" => n * s * 20.0,
        // A uniform error of a quantum.
        _ => n * s * s / 12.0,
    }
}
