//! A cheap look at all mistakes: one simulation each, or none where only outputs are concerned.

use std::collections::BTreeSet;

use crate::together::each;
use fd_effect::Candidate;

use super::{
    hypotheses::{Hypothesis, hypotheses},
    misfit::{Look, Misfit},
    mistake::Mistake,
    trial::Trial,
};
use crate::{diagnose::Case, fit::FitError};

/// Mistakes that deserve a fit …
const LONGEST: usize = 8;
/// … and where a fit has more unknowns than these, which makes it long.
const FEWEST: usize = 3;
const LARGE: usize = 16;
/// Shifts of one input among several that are looked at first.
const COARSE: [i64; 14] = [1, -1, 2, -2, 3, -3, 5, -5, 8, -8, 13, -13, 20, -20];

/// The mistakes whose mending does not look worse than the log as it is read, the best first.
pub(super) fn shortlist(case: &Case<'_>) -> Result<Vec<Hypothesis>, FitError> {
    let mut as_read = Trial::new(case, None)?;
    let all = hypotheses(case.nominal.model(), as_read.simulator());
    let nominal = as_read.simulated();
    let rough = |simulated: &Option<Vec<Vec<f64>>>| {
        let simulated = simulated.as_ref()?;
        Some(as_read.misfit(simulated, Look::Rough)?.rough())
    };
    let limit = rough(&nominal).unwrap_or(f64::INFINITY);
    let zeros = zeros(case, &as_read, nominal.as_deref(), &all);
    let delayed = delayed(case);
    let is_other = |h: &&Hypothesis| match &h.mistake {
        Mistake::Parameter { .. } | Mistake::Zero { .. } => false,
        // What a delay can be is one.
        Mistake::Clock { channel, late } => !delayed.contains(&(channel.clone(), 0 < *late)),
        _ => true,
    };
    let others = all.iter().filter(is_other);
    let others = each(others, |hypothesis| {
        let misfit = look(case, &as_read, nominal.as_deref(), &hypothesis.mistake)?;
        Some((misfit.rough(), hypothesis))
    });
    let mut looked: Vec<(f64, &Hypothesis)> = others.into_iter().flatten().collect();
    looked.extend(parameters(&mut as_read, &all));
    looked.retain(|(rough, _)| *rough <= limit);
    looked.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Neighbouring shifts of a clock look alike: one late and one early are enough.
    let mut clocks: BTreeSet<(String, bool)> = BTreeSet::new();
    looked.retain(|(_, hypothesis)| match &hypothesis.mistake {
        Mistake::Clock { channel, late } => clocks.insert((channel.clone(), 0 < *late)),
        _ => true,
    });
    let uncertain = |p: &&fd_sim::model::Parameter| 0.0 < p.tolerance;
    let simulator = as_read.simulator();
    let unknowns =
        simulator.initial().len() + simulator.parameters().iter().filter(uncertain).count();
    let longest = if LARGE < unknowns { FEWEST } else { LONGEST };
    let looked = looked.into_iter().map(|(_, hypothesis)| hypothesis);
    Ok(zeros.into_iter().chain(looked).take(longest).cloned().collect())
}

/// Other zeros that bring a log nearer to what is simulated, the best first.
fn zeros<'h>(
    case: &Case<'_>,
    as_read: &Trial<'_>,
    nominal: Option<&[Vec<f64>]>,
    all: &'h [Hypothesis],
) -> Vec<&'h Hypothesis> {
    let read = nominal.and_then(|simulated| as_read.misfit(simulated, Look::Rough));
    let Some(limit) = read.map(|misfit| misfit.rough_about_zero()) else { return Vec::new() };
    let all = all.iter().filter(|h| matches!(h.mistake, Mistake::Zero { .. }));
    let all = each(all, |hypothesis| {
        let misfit = look(case, as_read, nominal, &hypothesis.mistake)?;
        Some((misfit.rough_about_zero(), hypothesis))
    });
    let mut found: Vec<(f64, &Hypothesis)> =
        all.into_iter().flatten().filter(|(misfit, _)| *misfit < limit).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, hypothesis)| hypothesis).collect()
}

/// Channels that a delay among the suspects can shift as a clock would, each with whether they would be logged late: an
/// input that acts late was logged early.
fn delayed(case: &Case<'_>) -> BTreeSet<(String, bool)> {
    let of = |candidate: Candidate| {
        let is_late = match candidate.label {
            "input-delay" => false,
            "sensor-delay" => true,
            _ => return None,
        };
        Some((candidate.site.name()?.to_owned(), is_late))
    };
    case.suspects.alone().into_iter().flatten().filter_map(of).collect()
}

/// How a mended log looks with everything at its nominal value; `None` where it is not looked at or
/// cannot be simulated.
fn look(
    case: &Case<'_>,
    as_read: &Trial<'_>,
    nominal: Option<&[Vec<f64>]>,
    mistake: &Mistake,
) -> Option<Misfit> {
    let simulator = as_read.simulator();
    let is_input = |name: &str| simulator.inputs().iter().any(|input| input.name == name);
    let inputs = mistake.channels().into_iter().filter(|name| is_input(name)).count();
    let is_alone = simulator.inputs().len() == 1;
    let again = match mistake {
        Mistake::Clock { late, .. } if 0 < inputs && !is_alone => {
            if !COARSE.contains(late) {
                return None;
            }
            true
        }
        // A shift of the only input is one of all outputs.
        Mistake::Clock { .. } => false,
        Mistake::Time { .. } => true,
        _ => 0 < inputs,
    };
    let mut trial = Trial::new(case, Some(mistake)).ok()?;
    let simulated = if again {
        trial.simulated()?
    } else {
        // What is simulated for the only input moves with it; beside the clock of an output it stays. Either
        // way, rows are lost at one end.
        let (late, is_moved) = match mistake {
            Mistake::Clock { late, .. } => (*late, 0 < inputs),
            _ => (0, false),
        };
        let lost = usize::try_from(late.unsigned_abs()).ok()? * simulator.outputs().len();
        let rows = |y: &Vec<f64>| {
            let end = y.len().checked_sub(lost)?;
            let range = if (0 < late) == is_moved { lost..y.len() } else { 0..end };
            Some(y.get(range)?.to_vec())
        };
        nominal?.iter().map(rows).collect::<Option<Vec<_>>>()?
    };
    trial.misfit(&simulated, Look::Rough)
}

/// All mistakes in parameters, simulated side by side.
fn parameters<'h>(as_read: &mut Trial<'_>, all: &'h [Hypothesis]) -> Vec<(f64, &'h Hypothesis)> {
    let known = as_read.simulator().parameters().to_vec();
    let nominal: Vec<f64> = known.iter().map(|p| p.value).collect();
    let set = |hypothesis: &'h Hypothesis| {
        let Mistake::Parameter { name, factor } = &hypothesis.mistake else { return None };
        let place = known.iter().position(|p| p.name == *name)?;
        let mut theta = nominal.clone();
        theta[place] /= factor;
        Some((hypothesis, theta))
    };
    let (which, sets): (Vec<&Hypothesis>, Vec<Vec<f64>>) = all.iter().filter_map(set).unzip();
    let found = as_read.simulated_with(&sets);
    let pairs = which.into_iter().zip(found);
    pairs
        .filter_map(|(hypothesis, simulated)| {
            Some((as_read.misfit(&simulated?, Look::Rough)?.rough(), hypothesis))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use fd_effect::{EverySite, Suspects, library};
    use fd_model::Record;
    use fd_sim::{model::Model, scales::ReplayScales};

    use super::*;

    const MODEL: &str = r#"
version = 1
kind = "equations"
name = "lag"
sample_time = 0.1
inputs = { u = { unit = "V" } }
outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
states = { x = { unit = "V", initial = 0.0, derivative = "u - x" } }
"#;

    /// The lag answers three samples late.
    #[test]
    fn what_a_delay_can_be_is_no_clock() {
        let model: Model = MODEL.parse().unwrap();
        let ts = model.sample_time().unwrap();
        let command = |k: i32| (0.3 * f64::from(k)).sin() + (0.11 * f64::from(k)).cos();
        let mut x = 0.0;
        let rows = (0..200).map(|k| {
            let row = ([command(k)], [x]);
            let u = command(k - 3);
            x = u + (-0.1_f64).exp() * (x - u);
            row
        });
        let rows: Vec<([f64; 1], [f64; 1])> = rows.collect();
        let (inputs, outputs) = (model.external_inputs(), model.output_channels());
        let logs = [Record::from_rows(inputs, outputs, rows, ts).unwrap()];
        let early = |suspects: &dyn Suspects| {
            let case = Case { nominal: &model, suspects, logs: &logs, held_out: &[] };
            let is_early = |h: &Hypothesis| match &h.mistake {
                Mistake::Clock { channel, late } => channel == "u" && *late < 0,
                _ => false,
            };
            shortlist(&case).unwrap().iter().any(is_early)
        };
        let none: Vec<Candidate> = Vec::new();
        assert!(early(&none));
        let u: Vec<f64> = (0..200).map(command).collect();
        let with = |label: &str| {
            let effects = library().into_iter().filter(|e| e.label() == label).collect();
            let scales = ReplayScales::of(&model, ts, &u, 200).unwrap();
            early(&EverySite::new(effects, &model, scales))
        };
        assert!(with("input-gain") && with("sensor-delay") && !with("input-delay"));
    }
}
