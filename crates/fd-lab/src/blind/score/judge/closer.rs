//! The real noise of a case, and the share of its gap that is really closed.

use std::ops::Range;

use fd_effect::with_default_sites;
use fd_gap::{
    fit::{Horizon, Log},
    shrink::{Paths, Settled, forecast_errors, gap},
};
use fd_model::{HeldInputs, Record};
use fd_numeric::rms;
use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Follower, Nominal, Simulator},
};
use fdiag::gap_study::follow;

use super::verdict::Verdict;
use crate::blind::{
    answer::Answer,
    error::BlindError,
    files::{Case, Variant},
    logs::Part,
    oracle::free_start,
    truth::{Scene, Truth},
};

/// Runs that no diagnosis has seen, from which the real share of the gap that is closed follows.
const FRESH: Range<u64> = 2..6;
/// A gap that is less than this above the noise cannot be shared out.
const REDUCIBLE: f64 = 0.02;
/// Noise floor reached: so much above the real noise.
const REACHED: f64 = 1.1;

/// The real noise, and the share that is really closed.
pub(super) fn look(
    case: &Case,
    truth: &Truth,
    answer: &Answer,
    verdict: &mut Verdict,
) -> Result<(), BlindError> {
    let model = case.model()?;
    let scene = Scene::new(truth, &model)?;
    let Some(noise) = noise(&scene, 0..1)? else { return Ok(()) };
    verdict.is_floor_reached = answer.gaps[1].len() == noise.len()
        && answer.gaps[1].iter().zip(&noise).all(|(gap, noise)| *gap <= REACHED * noise);
    let (Some(stated), Some(patched)) = (answer.closed, &answer.patched) else { return Ok(()) };
    if answer.sigma.len() != noise.len() || !verdict.is_visible {
        return Ok(());
    }
    let Ok(patched) = patched.parse::<Model>() else { return Ok(()) };
    let (_, [train, _]) = case.read(Variant::AsLogged, HeldInputs::Mean)?;
    verdict.really_closed = really_closed(&scene, &patched, answer, &train)?;
    verdict.is_covered =
        verdict.really_closed.map(|real| stated.interval[0] <= real && real <= stated.interval[1]);
    Ok(())
}

/// Root mean square of what noise does to each output in some runs, around the loop as well; `None`
/// when the plant diverges.
fn noise(scene: &Scene<'_>, runs: Range<u64>) -> Result<Option<Vec<f64>>, BlindError> {
    let mut squares = vec![0.0; scene.model.outputs.len()];
    let mut samples = 0.0;
    for run in runs {
        let (Some(noisy), Some(clean)) = (scene.log(run, true)?, scene.log(run, false)?) else {
            return Ok(None);
        };
        for k in 0..noisy.len() {
            for (square, (noisy, clean)) in
                squares.iter_mut().zip(noisy.y(k).iter().zip(clean.y(k)))
            {
                let d: f64 = noisy - clean;
                // A value is missing in both.
                *square += if d.is_finite() { d.powi(2) } else { 0.0 };
            }
            samples += 1.0;
        }
    }
    Ok(Some(squares.into_iter().map(|square: f64| (square / samples).sqrt()).collect()))
}

/// The share of the gap that is closed on fresh runs, forecast as the diagnosis forecasts: along the log where it
/// follows it, else freely.
fn really_closed(
    scene: &Scene<'_>,
    patched: &Model,
    answer: &Answer,
    train: &Record,
) -> Result<Option<f64>, BlindError> {
    let default_sites = with_default_sites(scene.model);
    let follower = follow(&default_sites, std::slice::from_ref(train))?;
    let Some(floor) = floor(scene, answer, follower.as_ref())? else { return Ok(None) };
    let around = follower.as_ref().map(|follower| follower.around(patched));
    let both = follower.as_ref().zip(around.as_ref());
    let [nominal, with]: [Box<dyn Simulator>; 2] = if let Some((follower, around)) = both {
        [follower.simulator(train.ts())?, around.simulator(train.ts())?]
    } else {
        let nominal = EquationSimulator::<f64>::new(scene.model)?;
        let with = EquationSimulator::<f64>::at(patched, nominal.ts())?;
        [Box::new(nominal), Box::new(with)]
    };
    let values: Vec<(String, f64)> =
        patched.parameters.iter().map(|p| (p.name.clone(), p.value)).collect();
    let (mut before, mut after): (Vec<Vec<Vec<f64>>>, Vec<_>) = (Vec::new(), Vec::new());
    for run in FRESH {
        let found = match &follower {
            Some(follower) => followed(scene, run, follower, &*nominal)?,
            None => fresh(scene, run, &*nominal)?,
        };
        let Some((nominal, log)) = found else { continue };
        let error = |simulator: &dyn Simulator, nuisances: &[(String, f64)]| {
            let settled = Settled { simulator, nuisances, effects: &[], paths: Paths::AsFitted };
            let logs = std::slice::from_ref(&log);
            forecast_errors(&*nominal, settled, logs, Horizon::FreeRun, &answer.sigma)
        };
        let found = [error(&*nominal, &answer.refit)?, error(&*with, &values)?];
        let [Some(without), Some(patched)] = found else { return Ok(None) };
        for (all, one) in [(&mut before, without), (&mut after, patched)] {
            all.resize_with(one.len(), Vec::new);
            all.iter_mut().zip(one).for_each(|(all, one)| all.extend(one));
        }
    }
    if before.is_empty() {
        return Ok(None);
    }
    let (before, after) = (gap(&before) - floor, gap(&after) - floor);
    Ok((REDUCIBLE * floor < before).then(|| 1.0 - after / before))
}

/// Root mean square of what noise leaves to a perfect forecast, in the diagnosis' units of it: where a log is followed,
/// of the innovations.
fn floor(
    scene: &Scene<'_>,
    answer: &Answer,
    follower: Option<&Follower<'_>>,
) -> Result<Option<f64>, BlindError> {
    let Some(noise) = noise(scene, FRESH)? else { return Ok(None) };
    let noise = match follower {
        Some(follower) => {
            let innovations = follower.model().outputs.iter().map(|output| output.noise);
            innovations.zip(noise).map(|(innovation, noise)| innovation.unwrap_or(noise)).collect()
        }
        None => noise,
    };
    Ok(Some(rms(noise.iter().zip(&answer.sigma).map(|(noise, sigma)| noise / sigma))))
}

type Run = Option<(Box<dyn Simulator>, Log)>;

/// A run that no diagnosis has seen, with its logged outputs among its inputs.
fn followed(
    scene: &Scene<'_>,
    run: u64,
    follower: &Follower<'_>,
    nominal: &dyn Simulator,
) -> Result<Run, BlindError> {
    let Some(log) = scene.log_of(run, Part::First, true)? else { return Ok(None) };
    // A record of this model can be followed.
    let Ok(record) = follower.record(&log.record) else { return Ok(None) };
    Ok(Some((nominal.boxed(), Log::new(&record, nominal, 1)?)))
}

/// A run that no diagnosis has seen, logged as the held-out one was: where that goes on or begins in
/// motion, it starts freely.
fn fresh(scene: &Scene<'_>, run: u64, nominal: &dyn Simulator) -> Result<Run, BlindError> {
    let conditions = &scene.truth.conditions;
    let part = if conditions.is_cut { Part::Second } else { Part::First };
    let Some(log) = scene.log_of(run, part, true)? else { return Ok(None) };
    if !conditions.is_cut && conditions.before == 0 {
        return Ok(Some((nominal.boxed(), Log::new(&log.record, nominal, 1)?)));
    }
    let free = free_start(scene.model, &log)?;
    let nominal = EquationSimulator::<f64>::at(&free, log.record.ts())?;
    let earlier = scene.log_of(run, Part::First, true)?.map(|first| first.record);
    let earlier: Vec<_> = earlier.into_iter().filter(|_| conditions.is_cut).collect();
    let own = Log::new(&log.record, &nominal, 1)?.continuing(&log.record, &earlier, &nominal)?;
    Ok(Some((Box::new(nominal), own)))
}
